"""The Markdown that docs/manual/ is written in: headings (###), paragraphs, lists (*), tables, blocks of code (four spaces), and
in a line `code`, *emphasis*, [links](there) and ![pictures](there)."""

import re

PICTURE = re.compile(r"!\[[^\]]*\]\([^)]*\)")
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)]*)\)")


def blocks(text):
    """Pairs of a block's kind (heading, code, list, table, paragraph) and its lines, cells or text."""
    for part in re.split(r"\n\s*\n", text.strip("\n")):
        lines = part.split("\n")
        if lines[0].startswith("### "):
            yield "heading", lines[0][4:]
            if lines[1:]:
                yield "paragraph", " ".join(lines[1:])
        elif lines[0].startswith("    "):
            yield "code", [line[4:] for line in lines]
        elif lines[0].startswith("* "):
            yield "list", [" ".join(item.split()) for item in re.split(r"^\* ", part, flags=re.MULTILINE)[1:]]
        elif lines[0].startswith("|"):
            yield "table", [cells(line) for line in lines if not re.fullmatch(r"[|\s:-]+", line)]
        else:
            yield "paragraph", " ".join(line.strip() for line in lines)


def cells(line):
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def without_pictures(text):
    return PICTURE.sub("", text).strip()


def spans(text):
    """Pairs of a span's kind (code, emphasis, link, plain) and its text; a link's text comes with where it leads."""
    pattern = re.compile(r"`([^`]+)`|(?<!\w)\*([^*]+)\*(?!\w)|" + LINK.pattern)
    at = 0
    for found in pattern.finditer(text):
        if found.start() > at:
            yield "plain", text[at:found.start()]
        code, emphasis, name, there = found.groups()
        if code is not None:
            yield "code", code
        elif emphasis is not None:
            yield "emphasis", emphasis
        else:
            yield "link", (name, there)
        at = found.end()
    if at < len(text):
        yield "plain", text[at:]
