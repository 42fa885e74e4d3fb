"""What bash offers behind the beginning of a command line.

    bash_completion_test.py FILE
"""

import os
import subprocess
import sys
import tempfile
import unittest

FILE = ""
# Bash hands over the words of the line and the number of the one that is completed, which is the last here.
SCRIPT = 'source "$1" || exit 9; shift; COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); ' \
         '[[ "$(complete -p "$1")" == *" -F _foreland $1" ]] || exit 8; _foreland; printf "%s\\n" "${COMPREPLY[@]}"'


class BashCompletion(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        for name in ("hills.fls", "hills.tif", "two words.fls", "serve.toml"):
            with open(os.path.join(self.folder.name, name), "w", encoding="utf-8"):
                pass
        os.mkdir(os.path.join(self.folder.name, "scenes"))

    def offered(self, *words):
        ran = subprocess.run(["bash", "--norc", "-c", SCRIPT, "bash", FILE, *words], capture_output=True, check=False, text=True, cwd=self.folder.name)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""), words)
        return ran.stdout.split("\n")[:-1] if ran.stdout != "\n" else []

    def test_subcommands(self):
        self.assertEqual(self.offered("foreland", "re"), ["remesh", "replay", "render"])
        self.assertEqual(self.offered("foreland", "--v"), ["--version"])
        self.assertEqual(self.offered("foreland", "help", "ser"), ["serve"])

    def test_options_of_the_subcommand(self):
        self.assertEqual(self.offered("foreland", "build", "--im"), ["--imagery", "--imagery-quality", "--imagery-alpha"])
        self.assertEqual(self.offered("foreland", "serve", "--im"), [])
        self.assertIn("--help", self.offered("foreland", "verify", "--"))

    def test_options_that_go_once_are_offered_once(self):
        self.assertEqual(self.offered("foreland", "serve", "--tau", "2", "--ta"), [])
        self.assertEqual(self.offered("foreland", "serve", "--allow-origin", "a", "--allow"), ["--allow-origin"])

    def test_words_that_an_option_takes(self):
        self.assertEqual(self.offered("foreland", "build", "--frame", ""), ["auto", "planar", "projected", "geographic"])
        self.assertEqual(self.offered("foreland", "fly", "ws://h", "--strategy", "p"), ["predict"])
        self.assertEqual(self.offered("foreland", "fly", "--strategy", "=", "p"), ["predict"])
        self.assertEqual(self.offered("foreland", "fly", "--strategy", "="), ["delay", "current", "predict"])

    def test_nothing_where_any_text_goes(self):
        self.assertEqual(self.offered("foreland", "serve", "--listen", ""), [])
        self.assertEqual(self.offered("foreland", "fly", "h"), [])

    def test_files_by_what_the_option_takes(self):
        self.assertEqual(self.offered("foreland", "serve", ""), ["hills.fls", "scenes", "two words.fls"])
        self.assertEqual(self.offered("foreland", "serve", "--config", ""), ["scenes", "serve.toml"])
        self.assertEqual(self.offered("foreland", "build", "hills.t"), ["hills.tif"])
        self.assertEqual(self.offered("foreland", "serve", "--web", ""), ["scenes"])

    def test_any_file_where_none_has_the_usual_name(self):
        self.assertEqual(self.offered("foreland", "serve", "--config", "hills.t"), ["hills.tif"])

    def test_the_executables_themselves(self):
        self.assertEqual(self.offered("foreland-build", "--fr"), ["--frame"])
        self.assertEqual(self.offered("foreland-verify", "two"), ["two words.fls"])


class Laboratory(BashCompletion):
    """What a build without the laboratory has no words for."""

    def test_subcommands_below(self):
        self.assertEqual(self.offered("foreland", "bench", "s"), ["sections", "surfaces"])
        self.assertEqual(self.offered("foreland", "bench", "load", "--pol"), ["--policies"])

    def test_lists_of_words(self):
        self.assertEqual(self.offered("foreland", "bench", "load", "--policies", "fifo,l"), ["fifo,least-laxity"])


if __name__ == "__main__":
    FILE = os.path.abspath(sys.argv.pop(1))
    with open(FILE, encoding="utf-8") as completion:
        has_laboratory = "foreland-bench" in completion.read()
    loader = unittest.defaultTestLoader
    cases = loader.loadTestsFromTestCase(Laboratory if has_laboratory else BashCompletion)
    sys.exit(not unittest.TextTestRunner().run(cases).wasSuccessful())
