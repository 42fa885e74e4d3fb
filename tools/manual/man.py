"""Manual pages for man(1), in the macros of man(7)."""

from . import markdown, pages, table

STATUS = "0 if all went well; 2 if the input, a file or an option was wrong, with a message on standard error that says what to do."


def escaped(text):
    """As roff prints it literally."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "".join(c if ord(c) < 128 else f"\\[u{ord(c):04X}]" for c in text)


def line(text):
    """A line of text, which is no request."""
    return "\\&" + text if text.startswith((".", "'")) else text


def inline(text):
    out = ""
    for kind, span in markdown.spans(markdown.without_pictures(text)):
        if kind == "code":
            out += f"\\fB{escaped(span)}\\fR"
        elif kind == "emphasis":
            out += f"\\fI{escaped(span)}\\fR"
        elif kind == "link":
            name, there = span
            out += escaped(name.replace("`", "")) + (f" <{escaped(there)}>" if "://" in there else "")
        else:
            out += escaped(span)
    return line(out)


def paragraph(text):
    shown = inline(text)
    if shown.strip("\\& .:"):
        yield from (".PP", shown)


def literal(lines):
    yield from (".PP", ".RS 4", ".EX", *(line(escaped(text)) for text in lines), ".EE", ".RE")


def rows(cells_of_rows):
    """A table as a list of terms. One of pictures says nothing here."""
    for first, *others in cells_of_rows[1:]:
        about = "; ".join(filter(None, map(inline, others)))
        if about:
            yield from (".TP", inline(first), about)


def body(text):
    for kind, content in markdown.blocks(text):
        if kind == "heading":
            yield ".SH " + escaped(content.upper())
        elif kind == "code":
            yield from literal(content)
        elif kind == "list":
            for item in content:
                yield from (".IP \\(bu 2", inline(item))
        elif kind == "table":
            yield from rows(content)
        else:
            yield from paragraph(content)


def option_groups(program):
    for group, members in program.groups():
        if group:
            yield f'.SS "{escaped(group)}"'
        for option in members:
            names = ", ".join(f"\\fB{escaped(name)}\\fR" for name in option["names"])
            value = f" \\fI{escaped(option['value'])}\\fR" if option["value"] and not option["positional"] else ""
            facts = f" [{option['facts']}]" if option["facts"] else ""
            yield from (".TP", names + value, inline(option["description"]) + escaped(facts))


def head(name, short, version):
    title = escaped(name.replace(" ", "-"))
    return [f'.TH "{title.upper()}" 1 "" "foreland {version}" "Foreland"', ".nh", ".SH NAME", f"{title} \\- {escaped(short)}"]


def examples(program):
    if not program.examples:
        return
    yield ".SH EXAMPLES"
    for example in program.examples:
        if example["what"]:
            yield from (".PP", line(escaped(example["what"][0].upper() + example["what"][1:] + ":")))
        yield from literal([example["command"]])


def page_of(program, programs, root):
    """foreland-NAME.1"""
    text = pages.prose(root, program.word)
    cut = text.find("### ")
    first, rest = (text, "") if cut < 0 else (text[:cut], text[cut:])
    out = head(program.name, program.short, programs.version)
    out += [".SH SYNOPSIS", f"\\fB{escaped(program.name)}\\fR{escaped(program.usage[len(program.name):])}"]
    if program.subcommands:
        out[-1] += " \\fISUBCOMMAND\\fR ..."
    out += [".SH DESCRIPTION", *body(first)]
    out += [".SH OPTIONS", *option_groups(program)] if program.options else []
    for sub in program.subcommands:
        out += [f'.SH "{escaped(sub.word.upper())}"', f"{escaped(sub.short)}", *literal([sub.usage]), *option_groups(sub)]
    out += body(rest)
    out += [".SH NOTES", *literal(program.footer.split("\n"))] if program.footer else []
    out += [*examples(program), ".SH EXIT STATUS", escaped(STATUS)]
    return finish(out + see_also(programs, program))


def see_also(programs, but=None):
    others = ["foreland"] * (but is not None) + [p.name.replace(" ", "-") for p in programs.all if p is not but]
    return [".SH SEE ALSO", ",\n".join(f"\\fB\\%{escaped(name)}\\fR(1)" for name in others)]


def overview(programs, root):
    """foreland.1"""
    out = head("foreland", "stream terrain to remote viewers", programs.version)
    out += [".SH SYNOPSIS", "\\fBforeland\\fR \\fISUBCOMMAND\\fR [\\fIARGUMENT\\fR]...", ".br",
            "\\fBforeland help\\fR \\fISUBCOMMAND\\fR", ".br", "\\fBforeland \\-\\-version\\fR"]
    out += [".SH DESCRIPTION", *body(pages.prose(root, "foreland")), ".SH SUBCOMMANDS"]
    for program in programs.all:
        out += [".TP", f"\\fB{escaped(program.name.replace(' ', '-'))}\\fR(1)", escaped(program.short)]
    out += [f'.SH "{pages.STRATEGIES.upper()}"', *body(pages.prose(root, "strategies")), ".SH EXIT STATUS", escaped(STATUS)]
    return finish(out + see_also(programs))


def finish(lines):
    lines = [l for before, l in zip(["", *lines], lines) if l != ".PP" or not before.startswith((".SH", ".SS"))]
    return '.\\" Made by tools/make_manual.py of the programs\' own tables of options.\n' + "\n".join(lines) + "\n"


def all_pages(programs, root):
    """Names of files and what they hold."""
    made = {"foreland.1": overview(programs, root)}
    for program in programs.all:
        made[program.name.replace(" ", "-") + ".1"] = page_of(program, programs, root)
    return made
