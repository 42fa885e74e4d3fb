#!/usr/bin/env python3
"""What the programs make of other people's files: every model in a folder is remeshed, every raster built.

  tools/try_files.py BIN FOLDER [--list]

BIN has foreland-remesh and foreland-build. A file is read right (no note), noted (read, and what was left out or taken is
said) or refused (exit code 2, by a message that names it). Anything else is a fault: another exit code, a refusal that does
not name the file, more than five minutes of a processor. Counts them by suffix; --list names each with its first note or message. Exits 1
if there is a fault, 2 if there is no file. Writes a temporary folder and nothing else."""
import argparse
import collections
import pathlib
import resource
import subprocess
import sys
import tempfile

MODELS = {".obj", ".ply", ".stl", ".glb", ".gltf"}
RASTERS = {".tif", ".tiff", ".asc", ".dem", ".hgt", ".nc", ".grd", ".img", ".vrt"}
KINDS = ["right", "noted", "refused", "fault"]


def command_of(programs, file, folder):
    if file.suffix.lower() in MODELS:
        program, more = "foreland-remesh", ["--base-triangles", "50", "--levels", "1", "--attempts", "1"]
    else:
        program, more = "foreland-build", []
    return [str(programs / program), str(file), "-o", str(folder / "out.fls"), "--threads", "1", *more]


def limit_time():
    """To five minutes of a processor, whatever else runs; then a signal ends the program."""
    resource.setrlimit(resource.RLIMIT_CPU, (300, 300))


def judge(programs, file, folder):
    """The kind of a file, and its first note or its message."""
    ended = subprocess.run(command_of(programs, file, folder), capture_output=True, text=True, errors="replace", preexec_fn=limit_time)
    said = (ended.stdout + ended.stderr).strip().splitlines()
    notes = [line for line in said if line.startswith("note:") and " triangles became " not in line]  # which is always said
    last = said[-1] if said else ""
    if ended.returncode == 0:
        return ("noted", notes[0]) if notes else ("right", "")
    if ended.returncode == 2 and file.name in last:
        return "refused", last
    return "fault", f"exit code {ended.returncode}: {last}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    files = sorted(f for f in options.folder.rglob("*") if f.is_file() and f.suffix.lower() in MODELS | RASTERS)
    counts = collections.defaultdict(collections.Counter)
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            kind, words = judge(options.bin, file, pathlib.Path(folder))
            for row in (file.suffix.lower(), "all"):
                counts[row][kind] += 1
            if options.list or kind == "fault":
                print(f"{kind}\t{file.relative_to(options.folder)}\t{words}", flush=True)
    for row in sorted(counts):
        print(row, *(f"{counts[row][kind]} {kind}" for kind in KINDS), sep="\t")
    return 2 if not files else 1 if counts["all"]["fault"] else 0


if __name__ == "__main__":
    sys.exit(main())
