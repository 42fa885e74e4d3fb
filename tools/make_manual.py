#!/usr/bin/env python3
"""Makes the manual, manual pages, shell completion and the schema of serve.toml of the programs' own tables of options.

    tools/make_manual.py BIN --write       docs/MANUAL.md; BIN holds the programs, the laboratory's as well
    tools/make_manual.py BIN --check       says where docs/MANUAL.md is not what that would write, and exits 1 then
    tools/make_manual.py BIN --out DIR     man/man1, bash-completion, zsh, fish and foreland/serve.schema.json in DIR

    --without-laboratory                   BIN has no `foreland link` and `foreland bench`; not with --write
"""

import os
import shutil
import sys

import source_files
from manual import completion, man, pages, schema, table


def write(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def differences(programs, root, with_laboratory):
    """What is wrong with the committed page, a line each. Without the laboratory its sections are not looked at."""
    with open(os.path.join(root, pages.PAGE), encoding="utf-8") as file:
        committed = file.read()
    if with_laboratory and committed != pages.page(programs, root):
        wanted = pages.page(programs, root).split("\n")
        lines = committed.split("\n")
        at = next((i for i, (a, b) in enumerate(zip(lines, wanted)) if a != b), min(len(lines), len(wanted)))
        yield f"{pages.PAGE}:{at + 1}: is not what the programs' options and {pages.FOLDER}/ give; run tools/make_manual.py BIN --write"
    if not with_laboratory:
        for word, text in pages.sections(programs, root):
            if word and text + "\n" not in committed:
                yield f"{pages.PAGE}: the section of {word} is not what its options and {pages.FOLDER}/ give"


def make(programs, root, out):
    folder = os.path.join(out, "man/man1")
    shutil.rmtree(folder, ignore_errors=True)  # a build may have lost a program
    for name, text in man.all_pages(programs, root).items():
        write(os.path.join(folder, name), text)
    write(os.path.join(out, "bash-completion/completions/foreland"), completion.bash(programs))
    write(os.path.join(out, "zsh/vendor-completions/_foreland"), completion.zsh(programs))
    write(os.path.join(out, "fish/vendor_completions.d/foreland.fish"), completion.fish(programs))
    write(os.path.join(out, "foreland/serve.schema.json"), schema.text(programs.named("serve")))


def main(arguments):
    with_laboratory = "--without-laboratory" not in arguments
    words = [a for a in arguments if a != "--without-laboratory"]
    root = source_files.ROOT
    if len(words) == 3 and words[1] == "--out":
        make(table.Programs(words[0], with_laboratory), root, words[2])
        return 0
    if len(words) == 2 and words[1] == "--write" and with_laboratory:
        write(os.path.join(root, pages.PAGE), pages.page(table.Programs(words[0], True), root))
        return 0
    if len(words) == 2 and words[1] == "--check":
        found = list(differences(table.Programs(words[0], with_laboratory), root, with_laboratory))
        print("\n".join(found), end="\n" if found else "")
        return 1 if found else 0
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
