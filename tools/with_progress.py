#!/usr/bin/env python3
"""Runs a command quietly and shows how far it is.

    tools/with_progress.py WHAT LOG -- COMMAND ARG...

The command's output goes to the file LOG. On a terminal one line says how much is done and how long it will take, by the steps that
ninja ("[12/60] ...") and apt ("dlstatus:..:25.3:..", "pmstatus:..:25.3:..") report; elsewhere a line comes each half minute. If the
command fails, the end of its output is shown. Exits as the command does.
"""

import os
import re
import subprocess
import sys
import threading
import time

NINJA = re.compile(r"^\[(\d+)/(\d+)\]")
APT = re.compile(r"^(dl|pm)status:[^:]*:([\d.]+):")
DRAW_EVERY_S, SAY_EVERY_S = 0.5, 30
SHOWN_LINES = 40


class Progress:
    """What the command has said of its steps. Written by the reader's thread, read by the other."""

    def __init__(self):
        self.share, self.steps = None, ""

    def take(self, line):
        if found := NINJA.match(line):
            done, total = int(found[1]), int(found[2])
            self.share, self.steps = done / total, f"{done} of {total} steps"
        elif found := APT.match(line):
            percent = float(found[2])
            self.share = (percent if found[1] == "dl" else 100 + percent) / 200
            self.steps = "downloading" if found[1] == "dl" else "installing"


def duration(seconds):
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


def describe(what, progress, elapsed_s):
    parts = [progress.steps or duration(elapsed_s)]
    if progress.share and progress.share < 1 and elapsed_s > 3:
        parts.append(f"about {duration(elapsed_s * (1 - progress.share) / progress.share)} left")
    return f"{what}: " + ", ".join(parts)


def read(stream, log, progress):
    for line in stream:
        log.write(line)
        log.flush()
        progress.take(line)


def watch(process, reader, what, progress, began):
    is_terminal = sys.stderr.isatty()
    said = began
    while True:
        reader.join(DRAW_EVERY_S)
        now = time.monotonic()
        if not reader.is_alive():
            break
        if is_terminal:
            sys.stderr.write(f"\r\033[K  {describe(what, progress, now - began)}")
            sys.stderr.flush()
        elif now - said >= SAY_EVERY_S:
            said = now
            print(f"  {describe(what, progress, now - began)}", file=sys.stderr, flush=True)
    if is_terminal:
        sys.stderr.write("\r\033[K")
    return process.wait()


def main():
    if len(sys.argv) < 5 or sys.argv[3] != "--":
        print(__doc__, file=sys.stderr)
        return 2
    what, log_path, command = sys.argv[1], sys.argv[2], sys.argv[4:]
    progress, began = Progress(), time.monotonic()
    with open(log_path, "w", encoding="utf-8") as log:
        try:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                       errors="replace", env={**os.environ, "NINJA_STATUS": "[%f/%t] "})
        except OSError as error:
            print(f"{command[0]}: {error.strerror}", file=sys.stderr)
            return 1
        reader = threading.Thread(target=read, args=(process.stdout, log, progress))
        reader.start()
        try:
            code = watch(process, reader, what, progress, began)
        except KeyboardInterrupt:
            process.terminate()
            process.wait()
            return 130
    if code != 0:
        with open(log_path, encoding="utf-8", errors="replace") as log:
            print("".join(log.readlines()[-SHOWN_LINES:]), end="", file=sys.stderr)
        print(f"{what}: failed; all that it said is in {log_path}", file=sys.stderr)
    else:
        print(f"  {what}: done in {duration(time.monotonic() - began)}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
