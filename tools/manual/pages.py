"""docs/MANUAL.md: the prose of docs/manual/ and the programs' tables of options."""

import os
import re

from . import markdown, table

FOLDER = "docs/manual"
PAGE = "docs/MANUAL.md"
STRATEGIES = "The three strategies"
HEAD = ("<!-- tools/make_manual.py makes this page of the programs' own tables of options and of docs/manual/. "
        "Change those, and run it again. -->\n\n# Manual\n\n")


def prose(root, word):
    with open(os.path.join(root, FOLDER, word + ".md"), encoding="utf-8") as file:
        return file.read().strip("\n")


def moved(text):
    """Links of a page in docs/manual/, for a page in docs/."""
    def lead(found):
        there = found[2]
        if "://" in there or there.startswith("#"):
            return found[0]
        path = os.path.relpath(os.path.normpath(os.path.join(FOLDER, there)), os.path.dirname(PAGE))
        return f"{found[1]}({path})"
    return re.sub(r"(\[[^\]]*\])\(([^)]*)\)", lead, text)


def code(text):
    return "\n".join("    " + line if line else "" for line in text.split("\n"))


def cell(text):
    return text.replace("|", "\\|")


def options_of(program, printed):
    """Tables of options, a group each. A table that stands in the page already, as `printed` knows, is not repeated."""
    for group, options in program.groups():
        rows = [f"| `{cell(table.sign(o))}` | {cell(o['description'])} | {cell(o['facts'])} |" for o in options]
        key = (group, *rows)
        title = f"**{group}**\n\n" if group else ""
        if group and key in printed:
            yield f"**{group}**: as of `{printed[key]}`."
        else:
            printed[key] = program.name
            yield title + "| option | what it does | values |\n| --- | --- | --- |\n" + "\n".join(rows)


def examples_of(program):
    lines = []
    for example in program.examples:
        if example["what"]:
            lines.append(f"# {example['what']}")
        lines.append(example["command"])
    if lines:
        yield code("\n".join(lines))


def footer_of(program, told):
    """What --help ends with; a paragraph that another subcommand's section has, as `told` knows, is not repeated."""
    shown, paragraph = [], []
    for line in [*program.footer.split("\n"), ""]:
        if line:
            paragraph.append(line)
        elif paragraph:
            text = "\n".join(paragraph)
            shown.append(f"As of `{told[text]}`: {paragraph[0].rstrip(':')}." if text in told else code(text))
            told.setdefault(text, program.name)
            paragraph = []
    return "\n\n".join(shown)


def section_of(program, root, told):
    """The parts of a subcommand's section."""
    yield f"## `{program.name}`: {program.short}"
    yield code(program.usage + (" SUBCOMMAND ..." if program.subcommands else ""))
    text = moved(prose(root, program.word))
    head, *rest = re.split(r"^(?=### )", text, maxsplit=1, flags=re.MULTILINE)
    yield head.strip("\n")
    printed = {}
    yield from options_of(program, printed)
    yield from examples_of(program)
    if rest:
        yield rest[0].strip("\n")
    if program.footer:
        yield footer_of(program, told)
    for sub in program.subcommands:
        yield f"### `{sub.name}`: {sub.short}"
        yield code(sub.usage)
        yield from options_of(sub, printed)


def anchor(heading):
    """As GitHub names a heading."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def overview(programs):
    rows = []
    for program in programs.all:
        there = anchor(f"`{program.name}`: {program.short}")
        rows.append(f"| [`{program.name}`](#{there}) | {program.short} |")
    return "| command | what it is for |\n| --- | --- |\n" + "\n".join(rows) + f"\n\n[{STRATEGIES}](#{anchor(STRATEGIES)}) of `serve`, `fly` and the page come last."


def sections(programs, root):
    """The page, cut by its `##` headings: what is compared where a build lacks the laboratory."""
    yield "", HEAD + moved(prose(root, "foreland")) + "\n\n" + overview(programs)
    told = {}
    for program in programs.all:
        yield program.word, "\n\n".join(section_of(program, root, told))
    yield "strategies", f"## {STRATEGIES}\n\n" + moved(prose(root, "strategies"))


def page(programs, root):
    return "\n\n".join(text for _, text in sections(programs, root)) + "\n"
