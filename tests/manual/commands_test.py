"""Commands in the documents are ones that the programs take: subcommands, options, and words of options that take a few.

    commands_test.py BIN
"""

import os
import re
import shlex
import sys
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools"))

import source_files  # noqa: E402
from manual import table  # noqa: E402

BIN = ""
# Older than what they name may be; a decision stays as it was written.
HISTORY = ("docs/decisions/", "CHANGELOG.md")


def commands(text):
    """The commands in blocks and `spans` of a Markdown text: pairs of a line's number and the words after `foreland`."""
    for number, line in enumerate(text.split("\n"), 1):
        spans = [line.strip().removeprefix("$ ")] if line.startswith("    ") else re.findall(r"`([^`]+)`", line)
        for span in spans:
            # `foreland-lab_VERSION_amd64.deb` is a file, and `foreland-*` are many: no subcommand has such a name.
            found = re.match(r"(?:build/release/bin/)?foreland[ -]((?:[A-Za-z0-9-]+)?(?:\s.*)?)$", span)
            if found:
                yield number, words_of(found[1])


def words_of(text):
    """Without what is for the shell, or for readers: comments, redirections, brackets of what may be left out, and "or"."""
    text = re.split(r"\s[#>|&;]|\s2>|\s{3,}", text.replace("[", " ").replace("]", " "))[0]
    try:
        return shlex.split(text)
    except ValueError:
        return text.split()


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.programs = {sub.name.split(" ", 1)[1]: sub for p in table.Programs(BIN, True).all for sub in p.all()}

    def wrong(self, words):
        """What is wrong with a command, or None."""
        # `foreland flight 1` is the first line of a recording.
        if not words or words[0] in ("help", "SUBCOMMAND", "NAME", "--version", "flight"):
            return None
        path = " ".join(words[:2]) if " ".join(words[:2]) in self.programs else words[0]
        if path not in self.programs:
            return f"there is no foreland {path}"
        program = self.programs[path]
        below = [o for p in program.all() for o in p.named()]  # `foreland bench --json` is of its subcommands
        options = {name: o for o in below for name in o["names"]}
        for word, after in zip(words, [*words[1:], ""]):
            name, _, value = word.partition("=")
            if not re.fullmatch(r"--?[a-z][a-z-]*", name) or name in ("--help", "-h"):
                continue
            if name not in options:
                return f"foreland {path} has no option {name}"
            value = value or after
            if options[name].get("words") and re.fullmatch(r"[a-z][a-z0-9-]*", value) and value not in options[name]["words"]:
                return f"foreland {path} {name} does not take {value}"
        return None

    def test_wrong_commands_are_noticed(self):
        self.assertIsNone(self.wrong(words_of("build a.tif -o b.fls --frame planar  # one")))
        self.assertIsNotNone(self.wrong(words_of("biuld a.tif")))
        self.assertIsNotNone(self.wrong(words_of("build a.tif [--wings]")))
        self.assertIsNotNone(self.wrong(words_of("build a.tif --frame round")))
        self.assertIsNotNone(self.wrong(words_of("bench load a.fls --policies luck")))

    def test_all_commands_of_the_documents(self):
        checked = 0
        for path in source_files.ours(ROOT, (".md",)):
            if path.startswith(HISTORY):
                continue
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                for number, words in commands(file.read()):
                    checked += 1
                    with self.subTest(f"{path}:{number}"):
                        self.assertIsNone(self.wrong(words))
        self.assertGreater(checked, 200)


class Options(unittest.TestCase):
    """What a table of options must have for manual, completion and schema."""

    def test_each_says_what_it_does_and_what_it_takes(self):
        for program in (sub for p in table.Programs(BIN, True).all for sub in p.all()):
            self.assertTrue(program.options or program.subcommands, program.name)
            for option in program.options:
                with self.subTest(program.name, option=option["names"]):
                    self.assertGreater(len(option["description"]), 3)
                    self.assertFalse(option["description"].endswith("."))
                    self.assertNotIn("(default", option["description"])
                    self.assertNotEqual(option["value"], "TEXT", "give it a type_name()")


class Address(unittest.TestCase):
    """What the page reads from its address stands in the manual, and nothing else."""

    def test_the_manual_has_all_parameters(self):
        read = set()
        for source in ("client/web/src/ui/settings.ts", "client/web/src/main.ts"):
            with open(os.path.join(ROOT, source), encoding="utf-8") as file:
                read |= set(re.findall(r"(?:\b(?:oneOf|number|numberIn|flag|flagIn)\((?:query, )?|(?:query|location\.hash\.slice\(1\)\))\.(?:get|getAll|has)\()'(\w+)'", file.read()))
        with open(os.path.join(ROOT, "docs/manual/serve.md"), encoding="utf-8") as file:
            table_of_names = file.read().split("| in the address |")[1]
        told = {name for line in table_of_names.split("\n") for name in re.findall(r"`#?(\w+)=", line.split(" | ")[0])}
        self.assertEqual(read, told)
        self.assertIn("token", read)


if __name__ == "__main__":
    BIN = os.path.abspath(sys.argv.pop(1))
    unittest.main()
