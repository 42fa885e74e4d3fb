#!/usr/bin/env python3
"""Writes what Debian wants in /usr/share/doc of a package: `copyright`, and CHANGELOG.md as `changelog.gz`.

    tools/package_documents.py PACKAGE VERSION MAINTAINER FOLDER    PACKAGE is foreland, foreland-lab, libforeland-client0 or -dev
    tools/package_documents.py --self-test

Other makers' licences ask for their texts where their code is in what is shipped: in the programs, in the module of
WebAssembly, in the page, and in what the laboratory runs under node. The texts are those of the installed packages.
"""

import calendar
import gzip
import os
import re
import subprocess
import sys
import tempfile
import textwrap
import time
from email.utils import formatdate
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# Libraries of headers. Those of Boost, LLVM and fmt ask for no text beside compiled code.
DEBIAN = ["libcli11-dev", "libflatbuffers-dev", "libglm-dev", "libspdlog-dev", "libtomlplusplus-dev", "nlohmann-json3-dev"]
PAGE = ["three", "@takram/three-atmosphere", "geographiclib-dms", "geographiclib-geodesic", "suncalc", "@tmcw/togeojson", "@xmldom/xmldom", "fflate", "mediabunny", "proj4", "wkt-parser", "mgrs",
        "troika-three-text", "troika-three-utils", "troika-worker-utils", "webgl-sdf-generator", "bidi-js", "dejavu-fonts-ttf"]
CONTENTS = {
    "foreland": {"debian": [*DEBIAN, "wasi-libc"], "npm": [f"client/web/node_modules/{name}" for name in PAGE]},
    "libforeland-client0": {"debian": ["libflatbuffers-dev", "libglm-dev"], "npm": []},
    "libforeland-client-dev": {"debian": [], "npm": []},
    "foreland-lab": {"debian": [*DEBIAN, "wasi-libc"],
                     "npm": ["lab/report/node_modules/*", "lab/report/node_modules/@observablehq/*", "lab/martini/node_modules/@mapbox/martini",
                             "lab/wire/peers/node_modules/@here/quantized-mesh-decoder"]},
}

HEAD = """\
Foreland is free software: you may use, change and pass it on under the Apache License, version 2.0. On Debian systems
its text is in /usr/share/common-licenses/Apache-2.0.

Copyright 2026 the authors of Foreland

The programs and the page contain parts of the following, each under its own licence.
"""


def npm_notices(patterns):
    """(name, text) of each installed package that a pattern names."""
    for pattern in patterns:
        for folder in sorted(ROOT.glob(pattern)):
            if not (folder / "package.json").exists():
                continue
            files = [f for f in sorted(folder.iterdir()) if re.match(r"(licen[cs]e|copying)", f.name, re.IGNORECASE)]
            version = re.search(r'"version":\s*"([^"]+)"', (folder / "package.json").read_text()).group(1)
            name = str(folder).split("node_modules/")[-1]
            texts = [f.read_text(encoding="utf-8", errors="replace") for f in files]
            if not texts:
                found = re.search(r'"license":\s*"([^"]+)"', (folder / "package.json").read_text())
                texts = [f"License: {found.group(1) if found else 'see its package.json'}"]
            yield f"{name} {version} (npm)", "\n".join(texts)


def debian_notices(names):
    for name in names:
        path = Path("/usr/share/doc") / name / "copyright"
        if path.exists():
            yield f"{name} (Debian)", path.read_text(encoding="utf-8", errors="replace")


def copyright_of(package):
    parts = [HEAD]
    contents = CONTENTS[package]
    for name, text in [*npm_notices(contents["npm"]), *debian_notices(contents["debian"])]:
        body = "\n".join("  " + line.rstrip() if line.strip() else "" for line in text.strip().splitlines())
        parts.append(f"{'-' * 78}\n{name}\n\n{body}\n")
    return "\n".join(parts)


def releases_of(markdown, version):
    """(version, date or None, changes) of each heading of the second order; what is not released yet is `version`."""
    releases = []
    for line in markdown.splitlines():
        heading = re.match(r"## (\S+)(?:.*?(\d{4}-\d{2}-\d{2}))?", line)
        if heading:
            name = heading[1].strip("[]:,")
            releases.append((name if name[0].isdigit() else version, heading[2], []))
        elif releases and line.startswith("* "):
            releases[-1][2].append(line[2:].strip())
        elif releases and releases[-1][2] and line.startswith("  ") and line.strip():
            releases[-1][2][-1] += " " + line.strip()
    return [r for r in releases if r[2]]


def built_at():
    """When this version was made, the same for everybody who builds it."""
    if os.environ.get("SOURCE_DATE_EPOCH"):
        return int(os.environ["SOURCE_DATE_EPOCH"])
    committed = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=ROOT, capture_output=True, text=True)
    return int(committed.stdout) if committed.returncode == 0 and committed.stdout.strip() else int((ROOT / "CHANGELOG.md").stat().st_mtime)


def debian_changelog(markdown, version, maintainer, now):
    """In the form of deb-changelog(5), which wants a date of each release: one that states none is left out, unless it is `version`."""
    entries = []
    for name, date, changes in releases_of(markdown, version):
        if not date and name != version:
            continue
        at = calendar.timegm(time.strptime(date, "%Y-%m-%d")) if date else now
        lines = [line for change in changes
                 for line in textwrap.wrap(change, 78, initial_indent="  * ", subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)]
        entries.append("\n".join([f"foreland ({name}) unstable; urgency=medium", "", *lines, "", f" -- {maintainer}  {formatdate(at)}", ""]))
    return "\n".join(entries)


def write_documents(package, version, maintainer, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "copyright").write_text(copyright_of(package), encoding="utf-8")
    now = built_at()
    changes = debian_changelog((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), version, maintainer, now)
    with open(folder / "changelog.gz", "wb") as file, gzip.GzipFile("", "wb", 9, file, mtime=0) as packed:
        packed.write(changes.encode())


def self_test():
    text = debian_changelog("# Changelog\n\n## Unreleased\n\n* One `thing`\n  goes on.\n* " + "word " * 30 + "\n\n## 0.1.0 (2026-01-02)\n\n* Old.\n\n## 0.0.9\n\n* Older.\n", "0.2.0", "A B <a@b.example>", 0)
    expected = ["foreland (0.2.0) unstable; urgency=medium", "", "  * One `thing` goes on."]
    assert text.splitlines()[:3] == expected, text
    assert all(len(line) <= 78 for line in text.splitlines()), text
    assert text.count("\n -- A B <") == 2 and "foreland (0.1.0) unstable" in text and "Fri, 02 Jan 2026 00:00:00" in text and "Older" not in text, text
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "changelog").write_text(text)
        parsed = subprocess.run(["dpkg-parsechangelog", "-l", Path(folder) / "changelog", "-S", "Version"], capture_output=True, text=True)
        assert parsed.stdout == "0.2.0\n" and not parsed.stderr, parsed
    print("package_documents: the self-test passed")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
    elif len(sys.argv) == 5 and sys.argv[1] in CONTENTS:
        write_documents(*sys.argv[1:4], Path(sys.argv[4]))
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
