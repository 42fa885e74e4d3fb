#!/usr/bin/env python3
"""Holds the C interface's binary interface to client/c/abi.txt: functions, constants, and where each member of each struct is.

    tools/c_abi.py HEADER LIBRARY            says what differs, and exits 1 if anything does
    tools/c_abi.py HEADER LIBRARY --write    writes the list anew
    tools/c_abi.py --self-test HEADER        proves that a changed header is found out

The header is compiled as C99 on the way, with all warnings. What may change without another FORELAND_ABI: functions and
constants that are added, and members at the end of a struct that begins with its size.
"""

import difflib
import re
import subprocess
import sys
import tempfile
from pathlib import Path

GOLDEN = Path(__file__).resolve().parent.parent / "client/c/abi.txt"


def without_comments(text):
    return re.sub(r"/\*.*?\*/", " ", text, flags=re.S)


def c_part(header):
    """What C sees of it, on one line."""
    text = re.sub(r"#ifdef __cplusplus.*?#endif", " ", without_comments(header).replace("#else", "#endif\n#if 1"), flags=re.S)
    return " ".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))


def structs(text):
    for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\}", text):
        yield name, re.findall(r"(\w+)(?:\[\w+\])?\s*(?=[,;])", body)


def functions(text):
    for declared in re.findall(r"FORELAND_API ([^;]+\([^;]*\));", text):
        yield re.sub(r"\s+", " ", declared).strip()


def measured(header_path, text):
    """Sizes, offsets and constants, as a program of C tells them."""
    lines = []
    for name, members in structs(text):
        lines.append(f'printf("struct {name}: %zu\\n", sizeof({name}));')
        lines += [f'printf("  %zu %zu {m}\\n", offsetof({name}, {m}), sizeof((({name}*)0)->{m}));' for m in members]
    for body in re.findall(r"enum \{(.*?)\}", text):
        lines += [f'printf("{c} = %d\\n", (int){c});' for c in re.findall(r"\b(FORELAND_\w+) =", body)]
    source = f'#include "{header_path}"\n#include <stddef.h>\n#include <stdio.h>\nint main(void) {{ {" ".join(lines)} return 0; }}\n'
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "abi.c"
        path.write_text(source, encoding="utf-8")
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", path, "-o", path.with_suffix("")], check=True)
        return subprocess.run([path.with_suffix("")], capture_output=True, text=True, check=True).stdout


def exported(library):
    listed = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    return sorted(line.split()[-1] for line in listed.splitlines())


def described(header_path, symbols):
    header = Path(header_path).read_text(encoding="utf-8")
    text = c_part(header)
    abi = re.search(r"#define FORELAND_ABI (\d+)", header)[1]
    declared = sorted(functions(text))
    return "\n".join([f"ABI {abi}", "", "Exported:", *symbols, "", "Declared:", *declared, "", measured(Path(header_path).resolve(), text)])


def self_test(header_path):
    header = Path(header_path).read_text(encoding="utf-8")
    before = described(header_path, [])
    for old, new in (("uint32_t keyframes, late_keyframes;", "uint64_t keyframes, late_keyframes;"), ("FORELAND_ARGUMENT = 2", "FORELAND_ARGUMENT = 9"),
                     ("foreland_jump(ForelandTerrain* terrain)", "foreland_jump(ForelandTerrain* terrain, int32_t far)")):
        assert old in header, old
        with tempfile.TemporaryDirectory() as folder:
            changed = Path(folder) / "foreland.h"
            changed.write_text(header.replace(old, new), encoding="utf-8")
            if described(changed, []) == before:
                return f"'{new}' in place of '{old}' was not noticed"
    return None


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--self-test":
        wrong = self_test(sys.argv[2])
        print(wrong or "ok")
        return 1 if wrong else 0
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["--write"]):
        print(__doc__, file=sys.stderr)
        return 2
    now = described(sys.argv[1], exported(sys.argv[2]))
    if sys.argv[3:]:
        GOLDEN.write_text(now, encoding="utf-8")
        return 0
    golden = GOLDEN.read_text(encoding="utf-8") if GOLDEN.exists() else ""
    difference = list(difflib.unified_diff(golden.splitlines(), now.splitlines(), "client/c/abi.txt", "built", lineterm=""))
    print("\n".join(difference))
    if difference:
        print("The binary interface has changed. If hosts that were built before go on working, or FORELAND_ABI has changed with it:\n"
              f"    tools/c_abi.py {sys.argv[1]} {sys.argv[2]} --write")
    return 1 if difference else 0


if __name__ == "__main__":
    sys.exit(main())
