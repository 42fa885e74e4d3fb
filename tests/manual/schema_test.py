"""The schema of serve.toml and the server agree on which keys there are and which values they may have.

    schema_test.py SCHEMA SERVER
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest

SCHEMA, SERVER = {}, ""


def is_type(value, name):
    kinds = {"string": str, "integer": int, "number": (int, float), "array": list, "object": dict}
    return isinstance(value, kinds[name]) and not isinstance(value, bool)


def faults(value, schema, where="file"):
    """What a validator of JSON schemas would find, of the keywords that this schema has; another keyword is a fault itself."""
    for keyword, wanted in schema.items():
        if keyword in ("$schema", "title", "description", "default"):
            continue
        elif keyword == "type":
            if not any(is_type(value, name) for name in (wanted if isinstance(wanted, list) else [wanted])):
                yield f"{where}: is no {wanted}"
        elif keyword == "enum":
            if value not in wanted:
                yield f"{where}: is none of {wanted}"
        elif keyword == "minimum":
            if is_type(value, "number") and value < wanted:
                yield f"{where}: is below {wanted}"
        elif keyword == "maximum":
            if is_type(value, "number") and value > wanted:
                yield f"{where}: is above {wanted}"
        elif keyword == "pattern":
            if isinstance(value, str) and not re.search(wanted, value):
                yield f"{where}: does not match {wanted}"
        elif keyword == "anyOf":
            if all(any(True for _ in faults(value, one, where)) for one in wanted):
                yield f"{where}: is none of what it may be"
        elif keyword == "items":
            for entry in value if isinstance(value, list) else []:
                yield from faults(entry, wanted, where)
        elif keyword == "properties":
            for key, inner in wanted.items():
                if key in value:
                    yield from faults(value[key], inner, key)
        elif keyword == "additionalProperties":
            assert wanted is False
            yield from (f"{key}: is unknown" for key in value if key not in schema["properties"])
        else:
            yield f"the schema has the keyword {keyword}, which this test does not know"


def toml(value):
    """A value of a key as TOML. JSON's texts, numbers and lists are TOML's, too."""
    return json.dumps(value)


class Schema(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def served(self, text, *options):
        """Exit code and output of a server that only reads its options."""
        path = os.path.join(self.folder.name, "serve.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        ran = subprocess.run([SERVER, "--config", path, "--print-config", *options], capture_output=True, check=False, text=True)
        return ran.returncode, ran.stdout

    def judge(self, key, value, is_right):
        """The schema and the server, of a file with this key; SCENE must be there for the server."""
        with self.subTest(key=key, value=value):
            self.assertEqual(not list(faults({key: value}, SCHEMA)), is_right, "by the schema")
            scene = "" if key == "SCENE" else 'SCENE = "a.fls"\n'
            code, printed = self.served(f"{scene}{key} = {toml(value)}\n")
            self.assertEqual(code == 0, is_right, "by the server")
            return printed

    def test_all_keys_that_the_server_knows_are_in_it_and_no_others(self):
        code, printed = self.served('SCENE = "a.fls"\n')
        self.assertEqual(code, 0)
        self.assertEqual(sorted(tomllib.loads(printed)), sorted(SCHEMA["properties"]))

    def test_what_the_server_prints_is_right(self):
        for options in ([], ["--tau", ".5", "--keyframe-ms", "adaptive", "--allow-origin", "https://a", "--allow-origin", "https://b", "--log", "json"]):
            code, printed = self.served('SCENE = "a \\"b\\".fls"\n', *options)
            self.assertEqual(code, 0)
            self.assertEqual(list(faults(tomllib.loads(printed), SCHEMA)), [])
        self.assertEqual(tomllib.loads(printed)["tau"], 0.5)
        self.assertEqual(tomllib.loads(printed)["allow-origin"], ["https://a", "https://b"])
        self.assertEqual(tomllib.loads(printed)["SCENE"], ['a "b".fls'])

    def test_right_values_are_taken_by_both(self):
        for key, schema in SCHEMA["properties"].items():
            for value in [schema[k] for k in ("minimum", "maximum", "default") if k in schema] + schema.get("enum", []):
                printed = self.judge(key, value, True)
                if value != "":
                    self.assertEqual(tomllib.loads(printed)[key], value)

    def test_texts_and_lists_are_taken_by_both(self):
        for key, schema in SCHEMA["properties"].items():
            if schema.get("type") == "string" and "enum" not in schema:
                self.judge(key, "127.0.0.1:80", True)
            if "anyOf" in schema:
                self.judge(key, "a", True)
                self.judge(key, ["a", "b"], True)
        for value in ("adaptive", "100-500", 100):
            self.judge("keyframe-ms", value, True)

    def test_wrong_values_are_refused_by_both(self):
        for key, schema in SCHEMA["properties"].items():
            if "minimum" in schema:
                self.judge(key, schema["minimum"] - 1, False)
                self.judge(key, schema["maximum"] + 1, False)
                self.judge(key, "many", False)
                self.judge(key, [schema["minimum"], schema["maximum"]], False)
            if schema.get("type") == "integer":
                self.judge(key, schema["minimum"] + 0.5, False)
            if "enum" in schema:
                self.judge(key, "perhaps", False)
            if "pattern" in schema:
                self.judge(key, "fast", False)

    def test_wrong_types_are_refused_by_both(self):
        for key in SCHEMA["properties"]:
            self.judge(key, True, False)
            self.assertEqual(self.served(f'SCENE = "a.fls"\n[{key}]\nx = 1\n')[0], 2)
            self.assertNotEqual(list(faults({key: {"x": 1}}, SCHEMA)), [])

    def test_unknown_keys_are_refused_by_both(self):
        for key in ("wings", "config", "print-config", "help", "scene"):
            self.judge(key, "x", False)


if __name__ == "__main__":
    with open(sys.argv.pop(1), encoding="utf-8") as file:
        SCHEMA = json.load(file)
    SERVER = sys.argv.pop(1)
    unittest.main()
