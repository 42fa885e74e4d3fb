#!/usr/bin/env python3
"""Says which stages of ./check a change can reach.

    tools/changed.py --since REV    prints a line `stages NAME...`: what has changed since REV, uncommitted and new files included

A stage is left out only where no file that it reads has changed. Of its tests tools/passed_tests.py leaves out those that have passed.
"""

import subprocess
import sys

PAGE = ("client/", "proto/", "base/", "server/", "terrain/", "transport/", "apps/", "tools/build_page.sh", "cmake/", "CMake")
NATIVE = ("base/", "transport/", "proto/", "terrain/", "server/", "client/", "oracle/", "sim/", "lab/", "apps/", "examples/", "tests/", "deploy/", "cmake/",
          "CMake", "tools/", "check", "demo", "docs/manual/", "docs/PROTOCOL.md", ".clang")

def changed(rev):
    listed = subprocess.run(["git", "diff", "--name-only", rev], capture_output=True, text=True, check=True).stdout.split("\n")
    new = subprocess.run(["git", "ls-files", "--others", "--exclude-standard"], capture_output=True, text=True, check=True).stdout.split("\n")
    return [path for path in listed + new if path]


def main():
    if len(sys.argv) != 3 or sys.argv[1] != "--since":
        print(__doc__, file=sys.stderr)
        return 2
    paths = changed(sys.argv[2])
    native = any(p.startswith(NATIVE) and not p.startswith(("client/web/", "client/js/")) for p in paths)
    stages = {"packages", "layers", "docs"} if paths else set()
    if native:
        stages |= {"format", "release", "test", "demo", "package", "lint", "asan", "tsan"}
    if any(p.startswith("docs/") for p in paths):  # tests hold documents to the programs
        stages |= {"release", "test"}
    if any(p.startswith(PAGE) for p in paths):
        stages |= {"release", "wasm", "page", "browser"}
    print("stages", *sorted(stages))
    return 0


if __name__ == "__main__":
    sys.exit(main())
