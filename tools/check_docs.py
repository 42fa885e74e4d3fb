#!/usr/bin/env python3
"""Checks that documents and comments name only what exists.

    tools/check_docs.py               prints each wrong name as FILE:LINE: ..., exits 1 if there is one
    tools/check_docs.py --self-test   plants wrong names of each kind in a scratch tree and checks that all are found

  * a path in backticks or in a link of a Markdown file exists (a glob matches something; build outputs are not checked);
  * a Markdown file that a source file names exists;
  * a source file that a comment names exists: by its path from the root, or, without folders, anywhere in the repository;
  * every subcommand in apps/ and lab/apps/ has a section in docs/MANUAL.md, and README.md has at most 100 lines;
  * every file with a lock is named in docs/THREADS.md.
"""

import fnmatch
import os
import re
import sys
import tempfile

import source_files

# Written by the build or by the user, so not in the repository.
OUTPUTS = ("build/", "../", "client/web/dist", "client/web/node_modules", "client/js/dist", "client/js/node_modules", "/")
SOURCE = (".h", ".cpp", ".cmake", "CMakeLists.txt", ".py", ".sh", ".fbs", ".js", ".mjs", ".ts", ".html", ".css")
TICKED = re.compile(r"`([^`\s]+)`")
LINK = re.compile(r"\]\(([^)\s#]+)[^)]*\)")
NAMED_DOC = re.compile(r"(?<![\w./-])((?:[\w-]+/)*[A-Za-z][\w-]*\.md)\b")
# A source file by name. The build writes *_generated.h.
NAMED_SOURCE = re.compile(r"(?<![\w./<*-])((?:[\w-]+/)*[\w-]+\.(?:h|cpp|py|sh|fbs|mjs|ts))\b(?![\w/(*]|\.\w)")
GENERATED = re.compile(r"_generated\.h$")
COMMENT_MARKS = {".h": "//", ".cpp": "//", ".fbs": "//", ".ts": "//", ".js": "//", ".mjs": "//", ".css": "//"}
MANUAL, README_LINES = "docs/MANUAL.md", 100
LOCK = re.compile(r"\bstd::(mutex|shared_mutex|recursive_mutex|condition_variable(_any)?)\b")


def looks_like_path(token, tops):
    """The path that a token in backticks means, or None: it begins in a top folder, or is a top-level or Markdown file."""
    token = token.removeprefix("./").split(":")[0]
    if "(" in token or "<" in token or "$" in token or token.startswith(OUTPUTS):
        return None
    if "/" in token:
        return token if token.split("/")[0] in tops else None
    return token if token in tops or token.endswith(".md") else None


class Tree:
    def __init__(self, root):
        self.root = root
        self.files = source_files.ours(root)
        self.folders = {os.path.dirname(f) for f in self.files}
        self.folders |= {"/".join(f.split("/")[:n]) for f in self.folders for n in range(1, f.count("/") + 1)}
        self.tops = {f.split("/")[0] for f in self.files}
        self.names = {os.path.basename(f) for f in self.files}

    def holds(self, path):
        path = os.path.normpath(path)
        if any(c in path for c in "*?["):
            return any(fnmatch.fnmatch(f, path) for f in self.files)
        return path in self.folders or path in self.files

    def lines(self, path):
        with open(os.path.join(self.root, path), encoding="utf-8") as file:
            yield from enumerate(file.read().split("\n"), 1)


def lies_of_document(tree, path):
    for number, line in tree.lines(path):
        for token in TICKED.findall(line):
            named = looks_like_path(token, tree.tops)
            if named and not tree.holds(named) and not tree.holds(os.path.join(os.path.dirname(path), named)):
                yield f"{path}:{number}: names `{token}`, which does not exist"
        for target in LINK.findall(line):
            if "://" not in target and not tree.holds(os.path.join(os.path.dirname(path), target)):
                yield f"{path}:{number}: links to {target}, which does not exist"


def comment_of(path, line):
    """What stands behind the mark of a comment, outside addresses such as https://...; comments of several lines are not used."""
    mark = COMMENT_MARKS.get(os.path.splitext(path)[1], "# ")
    found = re.search(r"(?:^|[^:\"'])" + mark + "(.*)", line)
    return found[1] if found else ""


def gone_sources(tree, path, line):
    for named in NAMED_SOURCE.findall(comment_of(path, line)):
        if GENERATED.search(named):
            continue
        exists = tree.holds(named) or tree.holds(os.path.join(os.path.dirname(path), named)) if "/" in named else named in tree.names
        if not exists and ("/" not in named or named.split("/")[0] in tree.tops):
            yield named


# "THEORY section 3", "docs/PROTOCOL.md, section 10", "[x](PROTOCOL.md), section 15"; in comments the section's number may stand on the next line.
SECTION_OF = re.compile(r"(?<![\w])(?:[\w./]*/)?([A-Z][A-Z_]{3,})(?:\.md)?\)?,?\s(?://\s)?section\s(?://\s)?(\d+)")
DECISION = re.compile(r"\bdecisions?(?:/|\s+\[?)(\d{4})\b")


def false_citations(tree, path):
    """Sections of documents, and decisions, that are not there."""
    text = "\n".join(line for _, line in tree.lines(path))
    for cited in SECTION_OF.finditer(text):
        document = next((d for d in (f"docs/{cited[1]}.md", f"{cited[1]}.md") if tree.holds(d)), None)
        headings = "\n".join(line for _, line in tree.lines(document)) if document else ""
        if not re.search(rf"^## {cited[2]}\.? ", headings, re.MULTILINE):
            yield f"{path}:{text.count(chr(10), 0, cited.start()) + 1}: cites {cited[1]} section {cited[2]}, which does not exist"
    for cited in DECISION.finditer(text):
        if not any(f.startswith(f"docs/decisions/{cited[1]}-") for f in tree.files):
            yield f"{path}:{text.count(chr(10), 0, cited.start()) + 1}: cites decision {cited[1]}, which does not exist"


def lies_of_source(tree, path, threads):
    in_tests = path.startswith(("tests/", "lab/", "sim/", "oracle/", "tools/"))
    locks = False
    for number, line in tree.lines(path):
        if not path.startswith("tools/"):
            for named in NAMED_DOC.findall(line):
                if not tree.holds(named) and not tree.holds(os.path.join(os.path.dirname(path), named)):
                    yield f"{path}:{number}: names {named}, which does not exist"
        for named in gone_sources(tree, path, line):
            yield f"{path}:{number}: names {named}, which does not exist"
        if LOCK.search(line.split("//")[0]) and not in_tests and not locks:
            locks = True
            if path not in threads and os.path.splitext(path)[0] + ".h" not in threads:
                yield f"{path}:{number}: has a lock; give it a line in docs/THREADS.md"


def lies_of_subcommands(tree):
    if not tree.holds(MANUAL):
        yield f"{MANUAL}: does not exist; it has the subcommands' options"
        return
    manual = "\n".join(line for _, line in tree.lines(MANUAL))
    for path in filter(tree.holds, ("apps/CMakeLists.txt", "lab/apps/CMakeLists.txt")):
        for number, line in tree.lines(path):
            for name in re.findall(r"\bforeland_program\(\s*foreland-([\w-]+)", line):
                if not re.search(rf"^## .*foreland {name}\b", manual, re.MULTILINE):
                    yield f"{path}:{number}: {MANUAL} has no section for `foreland {name}`"


def lies_of_readme(tree):
    """It is for who knows nothing yet. Options and explanations go to the manual."""
    lines = sum(1 for _ in tree.lines("README.md")) - 1 if tree.holds("README.md") else 0
    if lines > README_LINES:
        yield f"README.md:{README_LINES + 1}: has {lines} lines; at most {README_LINES}"


def lies(root):
    tree = Tree(root)
    threads = ""
    if tree.holds("docs/THREADS.md"):
        threads = "\n".join(line for _, line in tree.lines("docs/THREADS.md"))
    for path in tree.files:
        if path.endswith(".md"):
            yield from lies_of_document(tree, path)
        elif path.endswith(SOURCE):
            yield from lies_of_source(tree, path, threads)
        if path.endswith((".md", *SOURCE)) and not path.startswith("tools/"):
            yield from false_citations(tree, path)
    yield from lies_of_subcommands(tree)
    yield from lies_of_readme(tree)


PLANTED = {
    "README.md": "`proto/topology/node.h` `proto/gone.h` `build/x` `proto/*.h` `proto/*.txt` [a](docs/A.md) [b](docs/B.md) `word`\n"
                 + 100 * "\n",
    "docs/MANUAL.md": "## `foreland fly`: fly\n",
    "docs/THEORY.md": "# Theory\n## 1. One\n## 2. Two\n",
    "docs/decisions/0003-a.md": "# A\n",
    "server/c.h": "// THEORY section 2 and (THEORY\n// section 3); DESIGN section 1; P section 4.\n// decisions 0003 and decision 0004\n",
    "docs/A.md": "`C.md` `../outside` `A.md` `proto/`\n",
    "docs/THREADS.md": "`server/a.h`: one\n",
    "proto/topology/node.h": "// see docs/A.md and docs/GONE.md, server/a.h, a.cpp, b.{h,cpp} and *.h\n"
                             "int a;  // (server/gone.h says why)\n// as in mesh.h\n#include <png.h>  // other_generated.h\n",
    "tools/a.py": "# see proto/gone/node.h\nx = 'https://host/gone.h'  # node.h\n",
    "server/a.h": "std::mutex m;\n",
    "server/a.cpp": "std::mutex m;\n",
    "server/b.cpp": "// std::mutex\nstd::shared_mutex m;\n",
    "apps/CMakeLists.txt": "foreland_program(foreland-fly SOURCES fly.cpp)\nforeland_program(foreland-new SOURCES new.cpp)\n",
    "lab/apps/CMakeLists.txt": "foreland_program(foreland-old SOURCES old.cpp)\n",
}
EXPECTED = ["names `proto/gone.h`", "names `proto/*.txt`", "links to docs/B.md", "names `C.md`", "names docs/GONE.md",
            "node.h:2: names server/gone.h", "node.h:3: names mesh.h", "a.py:1: names proto/gone/node.h",
            "server/b.cpp:2: has a lock", "c.h:1: cites THEORY section 3", "c.h:2: cites DESIGN section 1", "c.h:3: cites decision 0004", "no section for `foreland new`", "no section for `foreland old`", "README.md:101: has 101 lines"]


def self_test():
    with tempfile.TemporaryDirectory() as root:
        for path, content in PLANTED.items():
            os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(content)
        found = list(lies(root))
    failures = [f"not found: {e}" for e in EXPECTED if not any(e in line for line in found)]
    return failures + [f"wrongly found: {line}" for line in found if not any(e in line for e in EXPECTED)]


def main():
    if sys.argv[1:] not in ([], ["--self-test"]):
        print(__doc__, file=sys.stderr)
        return 2
    found = self_test() if sys.argv[1:] else list(lies(source_files.ROOT))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
