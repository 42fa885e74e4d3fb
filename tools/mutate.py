#!/usr/bin/env python3
"""Breaks chosen lines of the engine, one at a time, and says which test notices: the mutations of tools/mutations.py.

    tools/mutate.py [--folder DIR] [--jobs N] [NAME...]    all mutations, or the named ones
    tools/mutate.py --list                                 their names, and where each one is found

Works on a clone of the last commit in DIR (default: build/mutate); the working tree is left alone. All mutations are compiled into
one build, each behind a switch that the environment variable FORELAND_MUTANT sets, so thirty of them cost one build of the test
executables concerned. First every test runs without a mutation and must pass; then each mutation runs its own tests until one
fails. Prints a line for each mutation, then the Markdown table of docs/MUTATIONS.md. Exits 1 if a mutation survives or cannot be
applied. Not a part of ./check.
"""

import argparse
import os
import subprocess
import sys
import time

import source_files
from mutations import MUTATIONS

TIMEOUT_S = 900
# Cheaper to build than a release; a mutation may leave a variable unused.
OPTIONS = ["-DBUILD_TESTING=ON", "-DFORELAND_WARNINGS_AS_ERRORS=OFF", "-DCMAKE_CXX_FLAGS_RELEASE=-O1"]
SWITCH = """// Written by tools/mutate.py: which mutation is in force, 0 for none.
#pragma once
#include <cstdlib>
namespace foreland {
inline const int mutant = std::getenv("FORELAND_MUTANT") ? std::atoi(std::getenv("FORELAND_MUTANT")) : 0;
}
"""


class MutationError(Exception):
    """A mutation that cannot be applied or built, so that it says nothing about the tests."""


def must(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, errors="replace")
    if done.returncode != 0:
        raise MutationError(f"{' '.join(command)}\n{(done.stdout + done.stderr)[-4000:]}")


def clone(folder):
    if not os.path.exists(os.path.join(folder, ".git")):
        must(["git", "clone", "-q", "--shared", source_files.ROOT, folder], source_files.ROOT)
    must(["git", "fetch", "-q", "origin", "HEAD"], folder)
    must(["git", "checkout", "-q", "-f", "--detach", "FETCH_HEAD"], folder)


def file_of(mutation, root):
    """The one file under the mutation's folder that holds its line exactly once. Found by content, because files are renamed."""
    found = []
    for path in source_files.ours(root, suffixes=source_files.CPP):
        if path.startswith(mutation.under):
            with open(os.path.join(root, path), encoding="utf-8") as file:
                found += [path] * file.read().count(mutation.line)
    if len(found) != 1:
        raise MutationError(f"found {len(found)} times under {mutation.under}, not once: {mutation.line}")
    return found[0]


def switched(mutation, number):
    """The line with a switch: a statement if it ends like one, else an expression."""
    if mutation.line.endswith(";"):
        return f"if (foreland::mutant == {number}) {{ {mutation.instead} }} else {{ {mutation.line} }}"
    return f"(foreland::mutant == {number} ? ({mutation.instead}) : ({mutation.line}))"


def inject(mutations, folder):
    """Writes all mutations into the clone; {name: file}."""
    files = {m.name: file_of(m, folder) for m in mutations}
    with open(os.path.join(folder, "base", "mutant.h"), "w", encoding="utf-8") as file:
        file.write(SWITCH)
    for path in sorted(set(files.values())):
        full = os.path.join(folder, path)
        with open(full, encoding="utf-8") as file:
            text = file.read()
        for number, m in enumerate(mutations, 1):
            if files[m.name] == path:
                text = text.replace(m.line, switched(m, number))
        with open(full, "w", encoding="utf-8") as file:
            file.write('#include "base/mutant.h"\n' + text)
    return files


def first_failure(test, number, folder):
    """The first case of `test` (EXECUTABLE or EXECUTABLE:FILTER) that fails with this mutation, or None."""
    name, _, pattern = test.partition(":")
    command = [os.path.join("build", "release", "bin", name), "--gtest_fail_fast", "--gtest_brief=1"]
    if pattern:
        command.append(f"--gtest_filter={pattern}")
    try:
        done = subprocess.run(command, cwd=folder, timeout=TIMEOUT_S, capture_output=True, text=True, check=False, errors="replace",
                              env={**os.environ, "FORELAND_MUTANT": str(number)})
    except subprocess.TimeoutExpired:
        return f"{name}: does not end"
    if done.returncode == 0:
        if "PASSED  ] 0 tests" in done.stdout:
            raise MutationError(f"{test} holds no test")
        return None
    failed = [line for line in done.stdout.splitlines() if line.startswith("[  FAILED  ]")]
    return f"`{failed[0].split(']')[1].split('(')[0].split(',')[0].strip()}`" if failed else f"`{name}`, which ends early"


def judge(mutation, number, folder):
    """What notices the mutation, or None."""
    for test in mutation.tests:
        if noticed := first_failure(test, number, folder):
            return noticed
    return None


def row(mutation, path, noticed):
    def code(text):
        return "`" + " ".join(text.split()).replace("|", "\\|") + "`" if text.strip(" ;") else "(nothing)"
    return f"| {mutation.name} | `{path}` | {code(mutation.line)} | {code(mutation.instead)} | {noticed or '**survives**'} |"


def listed(mutations):
    bad = 0
    for m in mutations:
        try:
            print(f"{m.name:30} {file_of(m, source_files.ROOT)}")
        except MutationError as error:
            bad += 1
            print(f"{m.name:30} {error}")
    return 1 if bad else 0


def run(mutations, folder, jobs):
    clone(folder)
    files = inject(mutations, folder)
    executables = sorted({t.partition(":")[0] for m in mutations for t in m.tests})
    must(["cmake", "--preset", "release", *OPTIONS], folder)
    must(["cmake", "--build", "build/release", "-j", str(jobs), "--target", *executables], folder)
    for test in sorted({t for m in mutations for t in m.tests}):
        if failure := first_failure(test, 0, folder):
            raise MutationError(f"{test} fails without any mutation: {failure}")
    rows, caught = [], 0
    for number, m in enumerate(mutations, 1):
        began = time.monotonic()
        noticed = judge(m, number, folder)
        caught += noticed is not None
        print(f"{m.name:30} {'caught' if noticed else 'SURVIVES'} {time.monotonic() - began:5.1f} s  {noticed or ''}", flush=True)
        rows.append(row(m, files[m.name], noticed))
    print("\n| mutation | file | line | instead | noticed by |\n|---|---|---|---|---|\n" + "\n".join(rows))
    print(f"\n{caught} of {len(mutations)} caught")
    return 0 if caught == len(mutations) else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", default=os.path.join(source_files.ROOT, "build", "mutate"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--list", action="store_true")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    known = {m.name: m for m in MUTATIONS}
    if unknown := [n for n in arguments.names if n not in known]:
        parser.error(f"no mutation '{unknown[0]}'; --list names them")
    chosen = [known[n] for n in arguments.names] or MUTATIONS
    try:
        return listed(chosen) if arguments.list else run(chosen, arguments.folder, arguments.jobs)
    except MutationError as error:
        print(f"mutate: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
