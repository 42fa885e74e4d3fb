#!/usr/bin/env bash
# Makes the site of our documents, with figures and a search, in build/site/html; fails on a link that leads nowhere. Needs no network.
# `tools/make_site.sh --serve` shows it at http://127.0.0.1:8000.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
  "" | --serve) ;;
  *) echo "usage: tools/make_site.sh [--serve]" >&2; exit 2 ;;
esac

# The documents and what they link to, in the layout of the repository.
readonly sources=build/site/sources
rm -rf build/site
mkdir -p "$sources"
python3 - "$sources" <<'PYTHON'
import os, re, shutil, sys
sys.path.insert(0, "tools")
import source_files
LINK = re.compile(r"\]\(([^)\s#]+)")
documents = [path for path in source_files.ours(suffixes=[".md"]) if not path.startswith("docs/manual/")]  # MANUAL.md has that prose
wanted = set(documents)
for path in documents:
    with open(path, encoding="utf-8") as file:
        targets = LINK.findall(file.read())
    wanted |= {os.path.normpath(os.path.join(os.path.dirname(path), t)) for t in targets if "://" not in t}
for path in sorted(p for p in wanted if os.path.isfile(p)):
    os.makedirs(os.path.dirname(os.path.join(sys.argv[1], path)), exist_ok=True)
    shutil.copyfile(path, os.path.join(sys.argv[1], path))
PYTHON

mkdocs build --quiet --strict

# mkdocs looks for pages, not for the headings in them.
python3 - build/site/html <<'PYTHON'
import os, re, sys, urllib.parse
root, pages = sys.argv[1], {}
for folder, _, names in os.walk(root):
    for name in names:
        if name.endswith(".html") and name != "404.html":
            path = os.path.normpath(os.path.join(folder, name))
            with open(path, encoding="utf-8") as file:
                pages[path] = file.read()
anchors = {path: set(re.findall(r'\bid="([^"]+)"', page)) for path, page in pages.items()}
wrong = []
for path, page in pages.items():
    for target, anchor in re.findall(r'href="([^"#:]*)#([^"]+)"', page):
        to = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
        if to in anchors and urllib.parse.unquote(anchor) not in anchors[to]:
            wrong.append(f"{os.path.relpath(path, root)}: links to {target}#{anchor}, which is no heading")
print("\n".join(sorted(set(wrong))), end="\n" if wrong else "")
sys.exit(1 if wrong else 0)
PYTHON
[[ "${1:-}" != --serve ]] || exec python3 -m http.server --bind 127.0.0.1 --directory build/site/html 8000
