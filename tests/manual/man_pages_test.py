"""Manual pages are what man(1) formats without a warning, and they have what the programs say.

    man_pages_test.py DIR
"""

import os
import subprocess
import sys
import tempfile
import unittest

DIR = ""
FORMAT = ["man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8"]


def warnings(path):
    return subprocess.run([*FORMAT, "-Z", path], capture_output=True, check=False, encoding="utf-8").stderr


def shown(name):
    """The page as people see it, without bold and underlining, and with each run of spaces as one."""
    environment = {**os.environ, "MANPAGER": "cat", "MAN_KEEP_FORMATTING": "0", "MANWIDTH": "100", "GROFF_NO_SGR": "1"}
    page = subprocess.run(["man", "-E", "UTF-8", "-l", os.path.join(DIR, name)], capture_output=True, check=True, encoding="utf-8", env=environment)
    plain = []
    for character in page.stdout:
        if character == "\b":
            plain.pop()
        else:
            plain.append(character)
    return " ".join("".join(plain).split())


class ManualPages(unittest.TestCase):
    def test_all_are_formatted_without_a_warning(self):
        names = sorted(os.listdir(DIR))
        self.assertIn("foreland.1", names)
        self.assertIn("foreland-build.1", names)
        for name in names:
            with self.subTest(name):
                self.assertEqual(warnings(os.path.join(DIR, name)), "")

    def test_a_broken_page_would_be_noticed(self):
        with tempfile.NamedTemporaryFile("w", suffix=".1") as page:
            page.write(".TH X 1\n.SH NAME\nx \\- y\n.XYZ\n\\[nothing]\n")
            page.flush()
            self.assertIn("warning", warnings(page.name))

    def test_they_have_name_synopsis_options_and_examples(self):
        page = shown("foreland-build.1")
        for words in ("NAME foreland-build - make a scene file from elevation data", "SYNOPSIS foreland build INPUT... -o SCENE.fls [OPTION]...",
                      "-o, --output SCENE.fls the scene file to write", "[1 to 100; default 75; with --imagery]",
                      "EXAMPLES One file: foreland build hills.tif -o hills.fls", "EXIT STATUS 0 if all went well", "foreland-serve(1)"):
            self.assertIn(words, page)

    def test_lines_that_roff_would_take_for_its_own_are_shown(self):
        self.assertIn("a polygon model: .obj, .ply, .stl (text or binary), .glb or .gltf", shown("foreland-remesh.1"))
        self.assertIn("A .png file shows the colours", shown("foreland-render.1"))

    def test_the_programs_page_names_the_others(self):
        page = shown("foreland.1")
        for name in os.listdir(DIR):
            if name != "foreland.1":
                self.assertIn(name.removesuffix(".1") + "(1)", page)


if __name__ == "__main__":
    DIR = sys.argv.pop(1)
    unittest.main()
