#!/usr/bin/env python3
"""Runs clang-tidy (.clang-tidy) over the sources of the product, as many at a time as there are cores.

    tools/run_tidy.py BUILD_DIR    configured, with compile_commands.json in which every source stands alone (preset `lint`), and its
                                   generated headers built

Most of the time goes into the headers that sources include, so sources of a target are linted in units that include several, as the
builds compile them. If a unit finds anything, or does not compile, its sources are linted one by one, and what they find counts. A unit that was clean is
not looked at again until a source of it, a header of ours, its flags or .clang-tidy change. Tests are not linted.
"""

import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys

import source_files

ROOMS = ("base/", "transport/", "proto/", "terrain/", "server/", "client/", "oracle/", "sim/", "apps/")
MAX_IN_UNIT = 12  # as in cmake/Foreland.cmake, where no two sources of a unit use the same name
TARGET = re.compile(r"[^ ]*CMakeFiles/[^/ ]+\.dir")
# In a unit the sources are included files. That a source includes no other source is checked here instead.
IN_UNIT = ["--checks=-bugprone-suspicious-include"]
INCLUDES_SOURCE = re.compile(r'^\s*#\s*include\s*[<"][^">]+\.cpp[">]', re.MULTILINE)


def digest_of_all_headers():
    digest = hashlib.sha256()
    for path in [".clang-tidy", *source_files.ours(suffixes=[".h"])]:
        with open(os.path.join(source_files.ROOT, path), "rb") as file:
            digest.update(path.encode() + b"\0" + file.read())
    return digest.digest()


def flags_of(entry):
    """The command without its input and output."""
    words = shlex.split(entry["command"])
    at = words.index("-o")
    return [w for w in words[:at] + words[at + 2:] if w not in ("-c", entry["file"])]


def units_of(entries):
    """Lists of entries of one target that are compiled alike."""
    groups = {}
    for entry in entries:
        groups.setdefault((TARGET.search(entry["command"])[0], *flags_of(entry)), []).append(entry)
    return [group[i:i + MAX_IN_UNIT] for group in groups.values() for i in range(0, len(group), MAX_IN_UNIT)]


def read(path):
    with open(path, "rb") as file:
        return file.read()


def stamp_for(unit, headers, folder):
    text = headers + b"".join(e["command"].encode() + read(e["file"]) for e in unit)
    return os.path.join(folder, hashlib.sha256(text).hexdigest())


def tidy(database, source, *options):
    command = ["clang-tidy", "--quiet", "-p", database, f"--config-file={os.path.join(source_files.ROOT, '.clang-tidy')}",
               "--extra-arg=-Wno-unknown-warning-option",
               "--extra-arg=-Wno-unused-command-line-argument",  # g++'s own
               *options, source]
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=source_files.ROOT)
    return result.returncode, result.stdout + (result.stderr if result.returncode and not result.stdout else "")


def header_filter():
    """That of .clang-tidy, for sources as well."""
    with open(os.path.join(source_files.ROOT, ".clang-tidy"), encoding="utf-8") as file:
        headers = re.search(r"^HeaderFilterRegex: '(.*)'$", file.read(), re.MULTILINE)[1]
    return headers.replace(r"\.h$", r"\.(h|cpp)$")


def lint_unit(unit, stamp):
    """Whether nothing is found in all sources of the unit, looked at together."""
    folder = stamp + ".unit"
    os.makedirs(folder, exist_ok=True)
    source = os.path.join(folder, "unit.cpp")
    with open(source, "w", encoding="utf-8") as file:
        file.writelines(f'#include "{e["file"]}"\n' for e in unit)
    command = " ".join(shlex.quote(w) for w in [*flags_of(unit[0]), "-c", source])
    with open(os.path.join(folder, "compile_commands.json"), "w", encoding="utf-8") as file:
        json.dump([{"directory": unit[0]["directory"], "file": source, "command": command}], file)
    return tidy(folder, source, *IN_UNIT, f"--header-filter={header_filter()}")[0] == 0


def lint(unit, stamp, database):
    """(sources with findings, what was found)."""
    found = [f"{e['file']}: includes a source\n" for e in unit if INCLUDES_SOURCE.search(read(e["file"]).decode())]
    if len(unit) == 1 or not lint_unit(unit, stamp):
        results = [tidy(database, e["file"]) for e in unit]
        found += [text for code, text in results if code != 0]
    if not found:
        with open(stamp, "w", encoding="utf-8"):
            pass
    return len(found), "".join(found)


def main():
    if len(sys.argv) != 2 or not os.path.exists(os.path.join(sys.argv[1], "compile_commands.json")):
        print(__doc__, file=sys.stderr)
        return 2
    build = os.path.abspath(sys.argv[1])
    folder = os.path.join(build, "tidy")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        named = [e for e in json.load(file) if os.path.relpath(e["file"], source_files.ROOT).startswith(ROOMS)]
    entries = named
    with open(os.path.join(folder, "compile_commands.json"), "w", encoding="utf-8") as file:
        json.dump(entries, file)
    headers = digest_of_all_headers()
    todo = [(u, s) for u in units_of(entries) if not os.path.exists(s := stamp_for(u, headers, folder))]
    bad = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for count, text in pool.map(lambda job: lint(*job, folder), todo):
            if count != 0:
                bad += count
                print(text)
    print(f"{len(entries) - bad} of {len(entries)} sources are clean ({sum(len(u) for u, _ in todo)} looked at)")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
