#!/usr/bin/env python3
"""Checks that every header compiles by itself.

    tools/check_headers.py BUILD_DIR    configured, with compile_commands.json in which every source stands alone (preset `lint`), and its
                                        generated headers built

Each header is compiled in a unit that includes only it, with the flags of its folder's sources. The units lie in
BUILD_DIR/headers_alone; with ccache a second run costs little. Prints what the compiler says; exits 1 if a header fails.
"""

import concurrent.futures
import json
import os
import shlex
import subprocess
import sys

import source_files


def commands_by_folder(entries):
    by_folder = {}
    for entry in entries:
        folder = os.path.relpath(os.path.dirname(entry["file"]), source_files.ROOT)
        by_folder.setdefault(folder, []).append(entry)
    return by_folder


def flags_for(header, by_folder):
    """The command of the first source of the header's folder, else of a folder above or below it, without input, output and
    precompiled header."""
    folder = os.path.dirname(header)
    while folder and folder not in by_folder:
        below = sorted(f for f in by_folder if f.startswith(folder + "/"))
        folder = below[0] if below else os.path.dirname(folder)
    entries = by_folder.get(folder) or next(iter(by_folder.values()))
    words = shlex.split(entries[0]["command"])
    kept, skip = [], False
    for word in words:
        if skip:
            skip = False
        elif word in ("-o", "-c", "-include"):
            skip = True
        else:
            kept.append(word)
    return [w for w in kept if not w.startswith("-O")]


def compile_alone(header, by_folder, build):
    unit = os.path.join(build, "headers_alone", header + ".cpp")
    text = f'#include "{header}"\n'
    os.makedirs(os.path.dirname(unit), exist_ok=True)
    if not os.path.exists(unit) or open(unit, encoding="utf-8").read() != text:
        with open(unit, "w", encoding="utf-8") as file:
            file.write(text)
    command = [*flags_for(header, by_folder), "-O0", "-o", unit + ".o", "-c", unit]
    result = subprocess.run(command, cwd=build, capture_output=True, text=True, check=False)
    return header, result.returncode, result.stderr


def main():
    if len(sys.argv) != 2 or not os.path.exists(os.path.join(sys.argv[1], "compile_commands.json")):
        print(__doc__, file=sys.stderr)
        return 2
    build = os.path.abspath(sys.argv[1])
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    by_folder = commands_by_folder(entries)
    headers = source_files.ours(suffixes=[".h"])
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for header, code, errors in pool.map(lambda h: compile_alone(h, by_folder, build), headers):
            if code != 0:
                failed += 1
                print(f"{header}: does not compile by itself\n{errors}")
    print(f"{len(headers) - failed} of {len(headers)} headers compile by themselves")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
