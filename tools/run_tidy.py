#!/usr/bin/env python3
"""Runs clang-tidy (.clang-tidy) over the sources of the product, as many at a time as there are cores.

    tools/run_tidy.py BUILD_DIR    a configured build with compile_commands.json whose generated headers exist

A source that was clean is not looked at again until it, a header of ours, its flags or .clang-tidy change. Tests are not linted.
"""

import concurrent.futures
import hashlib
import json
import os
import subprocess
import sys

import source_files

ROOMS = ("base/", "proto/", "terrain/", "server/", "client/", "apps/")


def digest_of_all_headers():
    digest = hashlib.sha256()
    for path in [".clang-tidy", *source_files.ours(suffixes=[".h"])]:
        with open(os.path.join(source_files.ROOT, path), "rb") as file:
            digest.update(path.encode() + b"\0" + file.read())
    return digest.digest()


def stamp_for(entry, headers, folder):
    with open(entry["file"], "rb") as file:
        text = headers + entry["command"].encode() + file.read()
    return os.path.join(folder, hashlib.sha256(text).hexdigest())


def lint(entry, stamp, build):
    command = ["clang-tidy", "--quiet", "-p", build, "--extra-arg=-Wno-unknown-warning-option", entry["file"]]
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=source_files.ROOT)
    if result.returncode == 0:
        with open(stamp, "w", encoding="utf-8"):
            pass
    return result.returncode, result.stdout + (result.stderr if result.returncode and not result.stdout else "")


def main():
    if len(sys.argv) != 2 or not os.path.exists(os.path.join(sys.argv[1], "compile_commands.json")):
        print(__doc__, file=sys.stderr)
        return 2
    build = os.path.abspath(sys.argv[1])
    folder = os.path.join(build, "tidy")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        entries = [e for e in json.load(file) if os.path.relpath(e["file"], source_files.ROOT).startswith(ROOMS)]
    headers = digest_of_all_headers()
    todo = [(e, s) for e in entries if not os.path.exists(s := stamp_for(e, headers, folder))]
    bad = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for code, text in pool.map(lambda job: lint(*job, build), todo):
            if code != 0:
                bad += 1
                print(text)
    print(f"{len(entries) - bad} of {len(entries)} sources are clean ({len(todo)} looked at)")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
