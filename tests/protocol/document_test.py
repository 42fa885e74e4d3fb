#!/usr/bin/env python3
"""The document, the schema, the server and the decoder speak of the same version."""

import os
import re
import sys
import unittest

import wire

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def statements(schema):
    """A schema without comments, white space and namespace."""
    return re.sub(r"\s+", "", re.sub(r"//.*|namespace [\w.]+;", "", schema))


class Document(unittest.TestCase):
    document = read("docs/PROTOCOL.md")

    def test_shows_the_schema_that_is_compiled(self):
        shown = re.search(r"```fbs\n(.*?)```", self.document, re.DOTALL)
        self.assertEqual(statements(shown[1]), statements(read("proto/message/message.fbs")))

    def test_is_of_the_version_that_is_spoken(self):
        spoken = int(re.search(r"kProtocolVersion = (\d+);", read("proto/message/control.h"))[1])
        self.assertEqual(int(re.search(r"^Version (\d+)\.", self.document, re.MULTILINE)[1]), spoken)
        self.assertEqual(wire.VERSION, spoken)

    def test_shows_what_the_decoder_reads(self):
        shown = statements(re.search(r"```fbs\n(.*?)```", self.document, re.DOTALL)[1])
        tables = {name: [tuple(field.split(":")) for field in fields.split(";") if field]
                  for name, fields in re.findall(r"table(\w+)\{(.*?)\}", shown) if name != "Control"}
        self.assertEqual(tables, wire.TABLES)
        self.assertEqual(re.search(r"unionBody\{(.*?)\}", shown)[1].split(","), wire.BODIES)


if __name__ == "__main__":
    sys.exit(unittest.main())
