#!/usr/bin/env python3
"""Remembers which of ctest's tests have passed, and with which files, so that ./check --changed runs only what a change reaches.

    tools/passed_tests.py exclude BUILD_DIR            prints a pattern for `ctest -E` of tests that would read what they read when they passed
    tools/passed_tests.py note BUILD_DIR RESULTS.xml   notes the tests that passed, from ctest's report

A test reads its executable; the programs in bin/, if that names their folder; and the files of tests/ and lab/tests/ that are not compiled.
What Python or node runs reads sources as well, and is never left out.
"""

import hashlib
import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as xml

import source_files


def digest_of(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).digest()


def tests_of(build):
    """{name: executable} of the tests that are executables of the build."""
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True, check=True).stdout
    found = {}
    for test in json.loads(listed)["tests"]:
        command = test.get("command", [""])[0]
        if command.startswith(os.path.join(build, "bin") + os.sep):
            found[test["name"]] = command
    return found


def state_of(build):
    """{name: digest of all that the test reads}."""
    folder = os.path.join(build, "bin")
    listed = subprocess.run(["git", "ls-files", "tests", "lab/tests"], cwd=source_files.ROOT, capture_output=True, text=True, check=True).stdout
    data = hashlib.sha256()
    for path in listed.split("\n"):
        if path and not path.endswith((".cpp", ".h")) and os.path.isfile(os.path.join(source_files.ROOT, path)):
            data.update(path.encode() + digest_of(os.path.join(source_files.ROOT, path)))
    programs = hashlib.sha256()
    for name in sorted(os.listdir(folder)):
        if name.startswith("foreland"):
            programs.update(name.encode() + digest_of(os.path.join(folder, name)))
    digests, state = {}, {}
    for name, executable in tests_of(build).items():
        if executable not in digests:
            with open(executable, "rb") as file:
                binary = file.read()
            mark = hashlib.sha256(binary + data.digest())
            if folder.encode() in binary:
                mark.update(programs.digest())
            digests[executable] = mark.hexdigest()
        state[name] = digests[executable]
    return state


def main():
    if len(sys.argv) < 3 or (sys.argv[1], len(sys.argv)) not in (("exclude", 3), ("note", 4)):
        print(__doc__, file=sys.stderr)
        return 2
    build = os.path.abspath(sys.argv[2])
    stamps = os.path.join(build, "passed_tests.json")
    passed = {}
    if os.path.exists(stamps):
        with open(stamps, encoding="utf-8") as file:
            passed = json.load(file)
    state = state_of(build)
    if sys.argv[1] == "exclude":
        same = [re.escape(name) for name in state if passed.get(name) == state[name]]
        print(f"^({'|'.join(same)})$" if same else "", end="")
        return 0
    for case in xml.parse(sys.argv[3]).getroot().iter("testcase"):
        name = case.get("name")
        if name in state:
            passed.pop(name, None)
            if case.get("status") == "run":
                passed[name] = state[name]
    with open(stamps + ".new", "w", encoding="utf-8") as file:
        json.dump(passed, file, indent=1)
    os.replace(stamps + ".new", stamps)
    return 0


if __name__ == "__main__":
    sys.exit(main())
