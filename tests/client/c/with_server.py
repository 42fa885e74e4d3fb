#!/usr/bin/env python3
"""Runs a program at a server: makes a landscape and a scene, serves it, and replaces SERVER in the command by its address.

    tests/client/c/with_server.py BIN_FOLDER COMMAND...

Exits as the command does, and shows what it and the server said.
"""

import subprocess
import sys
import tempfile
from pathlib import Path


def main():
    if len(sys.argv) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    programs, command = Path(sys.argv[1]), sys.argv[2:]
    with tempfile.TemporaryDirectory() as folder:
        def run(name, *arguments):
            subprocess.run([programs / f"foreland-{name}", *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        run("synth", "-o", "hills.exr", "--size", "257", "--seed", "7")
        run("build", "hills.exr", "-o", "hills.fls")
        server = subprocess.Popen([programs / "foreland-serve", "hills.fls", "--listen", "127.0.0.1:0", "--log-level", "warning"],
                                  cwd=folder, stdout=subprocess.PIPE, text=True)
        try:
            line = server.stdout.readline().strip()
            if not line.startswith("serving "):
                print(f"the server did not start: {line}")
                return 1
            address = line.split()[-1].replace("http://", "ws://")
            return subprocess.run([address if word == "SERVER" else word for word in command], check=False).returncode
        finally:
            server.kill()
            server.wait()


if __name__ == "__main__":
    sys.exit(main())
