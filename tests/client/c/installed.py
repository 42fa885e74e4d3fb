#!/usr/bin/env python3
"""Installs the C interface into a folder and builds a program on it there, by CMake's find_package and by pkg-config.

    tests/client/c/installed.py BUILD_FOLDER VERSION
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = """#include <foreland.h>
#include <stdio.h>
int main(void) { return puts(foreland_version()) < 0 || foreland_abi() != FORELAND_ABI; }
"""
PROJECT = """cmake_minimum_required(VERSION 3.16)
project(host LANGUAGES C)
find_package(foreland_client VERSION REQUIRED)
add_executable(host host.c)
target_link_libraries(host PRIVATE foreland::client)
"""


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout.strip()


def main():
    build, version = Path(sys.argv[1]).resolve(), sys.argv[2]
    with tempfile.TemporaryDirectory() as folder:
        root, work = Path(folder) / "root", Path(folder) / "work"
        work.mkdir()
        for component in ("client", "client_dev"):
            run("cmake", "--install", build, "--prefix", root, "--component", component)
        (work / "host.c").write_text(PROGRAM, encoding="utf-8")
        (work / "CMakeLists.txt").write_text(PROJECT.replace("VERSION REQUIRED", f"{version} REQUIRED"), encoding="utf-8")
        run("cmake", "-S", work, "-B", work / "build", f"-DCMAKE_PREFIX_PATH={root}")
        run("cmake", "--build", work / "build")
        said = [run(work / "build/host")]

        found = next(root.rglob("foreland.pc"))
        where = {**os.environ, "PKG_CONFIG_PATH": str(found.parent)}
        flags = run("pkg-config", "--cflags", "--libs", "foreland", env=where).split()
        run("cc", work / "host.c", "-o", work / "host", *flags)
        said.append(run(work / "host", env={**os.environ, "LD_LIBRARY_PATH": str(found.parent.parent)}))
        said.append(run("pkg-config", "--modversion", "foreland", env=where))
    if said != [version] * 3:
        sys.exit(f"{said} instead of {version}")


if __name__ == "__main__":
    main()
