"""The programs' own tables of options, as they print them with --options-as-json (apps/options/option_table.h)."""

import json
import os
import subprocess
import sys

LABORATORY = ("link", "bench")  # subcommands that are not in every build

NUMBERS = ("whole", "number", "number or text")
FILES = ("file", "folder")


def asked(program):
    """What a program prints; the manual cannot be made without it."""
    ran = subprocess.run([program, "--options-as-json"], capture_output=True, check=False)
    if ran.returncode != 0:
        sys.exit(f"{program} --options-as-json: exit code {ran.returncode}: {ran.stderr.decode().strip()}")
    return json.loads(ran.stdout)


class Program:
    """`foreland build` and its like, or a subcommand of one: `foreland bench load`."""

    def __init__(self, about, short):
        self.name, self.usage, self.footer = about["name"], about["usage"], about["footer"].strip("\n")
        self.short = short  # `make a scene file from elevation data`
        self.options, self.examples = about["options"], about["examples"]
        self.subcommands = [Program(sub, sub["summary"]) for sub in about["subcommands"]]

    @property
    def word(self):
        return self.name.split()[-1]

    def groups(self):
        """Pairs of a group's name, empty for the first, and its options; positional ones come first."""
        names = dict.fromkeys(option["group"] for option in self.options)
        for name in names:
            options = [o for o in self.options if o["group"] == name]
            yield ("" if name == "Options" else name), sorted(options, key=lambda o: not o["positional"])

    def named(self):
        return [o for o in self.options if not o["positional"]]

    def positional(self):
        return [o for o in self.options if o["positional"]]

    def all(self):
        """Itself and all below it."""
        yield self
        for sub in self.subcommands:
            yield from sub.all()


class Programs:
    """All of a folder of executables, in the order in which `foreland --help` lists them."""

    def __init__(self, folder, with_laboratory):
        about = asked(os.path.join(folder, "foreland"))
        self.version, self.all = about["version"], []
        for sub in about["subcommands"]:
            if with_laboratory or sub["name"] not in LABORATORY:
                self.all.append(Program(asked(os.path.join(folder, "foreland-" + sub["name"])), sub["summary"]))

    def named(self, word):
        return next(p for p in self.all if p.word == word)


def sign(option):
    """`-o, --output FILE` as it is written."""
    if option["positional"]:
        return option["names"][0] + ("..." if option["repeatable"] else "")
    many = "..." if option["many_at_once"] else ""
    return ", ".join(option["names"]) + (f" {option['value']}{many}" if option["value"] else "")
