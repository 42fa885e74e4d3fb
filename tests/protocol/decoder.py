#!/usr/bin/env python3
"""A client's decoder, written from docs/PROTOCOL.md alone: replays a recorded session and says what the client then holds.

    decoder.py STREAM              prints a line for each keyframe
    decoder.py STREAM EXPECTED     compares the lines with those of the file; exits 1 at the first that differs

A line: index, nodes of the section, nodes added, nodes removed, fingerprint, CRC-32 of the slots, CRC-32 of their heights, CRC-32 of
what the refinement test makes of them, so that the arithmetic is compared to the last bit; then the same of all objects, if there
are any. README.md has the layout of both files.
Only Python's standard library is used.
"""

import struct
import sys
import zlib

import wire
from coder import RangeDecoder, read_sections
from epochs import Epochs
from objects import Objects
from section import Section
from terrain import Frame, Grid
from wire import ProtocolError, require


class Session:
    """What a client holds, and both directions of its connections: sections 3 to 5."""

    def __init__(self):
        self.section = None
        self.held = 0  # keyframe
        self.scene_id = None
        self.asked, self.replied = [], []  # ids
        self.connect()

    def connect(self):
        """A new connection."""
        self.has_asked = self.is_welcome = self.has_posed = self.is_refused = False
        self.acknowledged = self.taken = 0
        self.cells = []  # of the viewshed that is told
        self.updates, self.keyframes = wire.PoseUpdates(), wire.Keyframes()

    def up(self, message):
        """A message that the client sent."""
        require(self.has_asked or message[0] == wire.CONTROL, "a session that does not begin with a view request")
        if message[0] == wire.POSE or message[0] & 7 == wire.POSE_AFTER:
            self.pose(self.updates.read(message))
        elif message[0] == wire.RESUME:
            self.resume(wire.read_resume(message[1:]))
        else:
            require(message[0] == wire.CONTROL, "not a message of this protocol")
            self.ask(*wire.control(message[1:]))

    def pose(self, update):
        require(self.acknowledged <= update.received_keyframe <= self.taken, "an acknowledgement of nothing")
        self.acknowledged = update.received_keyframe
        self.has_posed = True

    def ask(self, name, fields):
        require(name in wire.FROM_CLIENT, "not one that a client sends")
        require(self.has_asked or name == "ViewRequest", "a session that does not begin with a view request")
        if name == "ViewRequest":
            require(fields["protocol"] == wire.VERSION, "a client of another version")
            if not self.has_asked:
                self.wanted_bytes = fields["memory_bytes"]
            self.has_asked = True
        elif name not in ("PathUpload", "SceneClock", "RequestCancel"):
            self.asked.append((name.replace("Request", "Reply"), fields["id"]))

    def resume(self, resume):
        require(self.is_welcome and not self.has_posed and self.taken == 0, "a resume message too early, or too late")
        require((resume.scene_id, resume.keyframe) == (self.scene_id, self.held), "another section than is held")
        terrain, objects, known, finest = read_sections(resume.section, self.section.grid, [s.surface for s in self.objects.sections])
        require(resume.fingerprint == self.fingerprint() and terrain == self.section.slots and
                objects == [s.slots for s in self.objects.sections], "another section than is held")
        self.section.begin_anew(known, finest, self.memory_bytes)
        self.objects.begin_anew()
        self.epochs.begin_anew()

    def fingerprint(self):
        return self.section.fingerprint + self.objects.fingerprint() & 0xFFFFFFFF

    def down(self, message):
        """A message that the server sent; the line of a keyframe, or None."""
        require(not self.is_refused, "a message after the refusal")
        if message[0] == wire.KEYFRAME or message[0] & 7 == wire.KEYFRAME_AFTER:
            return self.take(self.keyframes.read(message))
        if message[0] == wire.TILE:
            return None  # nothing of a section depends on it
        require(message[0] == wire.CONTROL, "not a message of this protocol")
        name, fields = wire.control(message[1:])
        require(name in wire.BODIES and name not in wire.FROM_CLIENT, "not one that a server sends")
        if name == "Welcome":
            self.welcome(fields)
        elif name == "Refusal":
            self.is_refused = True
        elif name == "ViewshedReply" and not fields["error"]:
            self.viewshed(fields)
        else:
            if name == "SightReply":
                require(fields["error"] or len(fields["ends"]) == 2 * len(fields["hits"]), "ends without an answer")
                require(all(hit[3] >= -3 for hit in fields["hits"] or []), "hidden by what there is not")
            self.replied.append((name, fields["id"]))
        return None

    def viewshed(self, fields):
        """Part of a viewshed; it is replied once it is whole."""
        cells, told = fields["columns"] * fields["rows"], fields["count"]
        self.cells = self.cells if fields["begin"] > 0 else []
        require(cells <= 1 << 22 and told <= 1 << 16 and fields["begin"] == len(self.cells), "cells out of order")
        packed = fields["cells"]
        require(len(packed) == (told + 3) // 4, "other cells than are counted")
        self.cells += [packed[i // 4] >> 2 * (i % 4) & 3 for i in range(told)]
        require(all(cell < 3 for cell in self.cells) and len(self.cells) <= cells, "cells that are neither seen nor hidden")
        if len(self.cells) == cells:
            self.replied.append(("ViewshedReply", fields["id"]))

    def welcome(self, fields):
        require(not self.is_welcome and fields["protocol"] == wire.VERSION, "a second welcome, or of another version")
        shape, corners, centres = fields["shape"], fields["corner_heights"], fields["centre_heights"]
        grid = Grid(shape, fields["frame"]["kind"] == 2)
        require(len(corners) == (grid.roots_x + 1) * (grid.roots_y + 1) and len(centres) == grid.roots_x * grid.roots_y and
                all(abs(h) < 1 << 22 for h in corners + centres), "base heights that do not fit the shape")
        require(fields["tau_px"] > 0 and fields["keyframe_interval_us"] > 0, "no tolerance, or no interval")
        frame = Frame(fields["frame"], grid.max_x, grid.max_y, fields["highest"])
        self.memory_bytes = fields["memory_bytes"]
        require(self.memory_bytes <= self.wanted_bytes, "more memory than was asked for")
        self.empty = lambda: Section(grid, frame, corners, centres, self.memory_bytes)
        keys = "position", "orientation", "scale", "model"
        placements = [dict(zip(keys, (p[:3], p[3:7], p[7], p[8]))) for p in fields["objects"] or []]
        if self.scene_id != fields["scene_id"]:  # else the client may resume from those that it holds
            self.section = None
            self.objects = Objects(fields["models"] or [], placements, len(fields["epochs"] or []), fields["epoch_blend"])
            self.epochs = Epochs(grid, shape, fields["epochs"] or [], fields["base_offsets"] or [], len(corners),
                                 fields["epoch_blend"])
        self.scene_id, self.is_welcome = fields["scene_id"], True

    def take(self, keyframe):
        require(self.is_welcome, "a keyframe before the welcome")
        require(keyframe.base in (0, self.held), "a keyframe from another one than is held")
        coder = RangeDecoder(keyframe.delta)
        if keyframe.base == 0:
            self.section = self.section or self.empty()
            keeps_pages = coder.even(1)
            require(self.taken > 0 or not keeps_pages, "pages kept from another connection")
            self.section.begin_from_nothing(keeps_pages)
            self.section.memory_bytes = self.memory_bytes
            self.objects.begin_from_nothing()
            if not keeps_pages:
                self.epochs.begin_anew()
        added, removed = self.section.step(keyframe.view, coder)
        self.objects.step(keyframe.view, coder, self.memory_bytes)
        nodes = [(slot, self.section.nodes[slot]) for slot in sorted(self.section.slots)] if self.epochs.times else []
        self.epochs.take(nodes, coder)
        coder.finish()
        fingerprint = self.fingerprint()
        require(fingerprint & keyframe.mask == keyframe.fingerprint, f"another section at keyframe {keyframe.index}")
        self.held = self.taken = keyframe.index
        heights = self.section.heights
        slots = sorted(self.section.slots)
        packed = [struct.pack(f"<{len(slots)}I", *slots), struct.pack(f"<{len(slots)}i", *(heights[s] for s in slots)),
                  b"".join(self.section.tests())]
        line = f"{keyframe.index} {len(slots)} {added} {removed} {fingerprint:08x} {sums_of(packed)}"
        if self.objects.sections:
            line += f" {' '.join(map(str, self.objects.counts()))} {sums_of(self.objects.packed())}"
        if self.epochs.times:
            line += f" {sums_of(self.epochs.packed(nodes))}"
        return line


def sums_of(packed):
    return " ".join(f"{zlib.crc32(data):08x}" for data in packed)


FROM_CLIENT, FROM_SERVER, NEW_CONNECTION = 0, 1, 2


def records(data):
    """(what, message) of a stream."""
    r = wire.Reader(data)
    require(r.take(8) == b"FLSTREAM", "not a stream")
    while r.at < len(data):
        what, _, size = r.number("B"), r.number("q"), r.number("I")
        require(what <= NEW_CONNECTION and (size > 0) == (what != NEW_CONNECTION), "not a stream")
        yield what, r.take(size)


def replay(data):
    """The lines of all keyframes of a stream."""
    session = Session()
    for what, message in records(data):
        if what == NEW_CONNECTION:
            session.connect()
        elif what == FROM_CLIENT:
            session.up(message)
        elif line := session.down(message):
            yield line
    require(session.replied == session.asked[:len(session.replied)], "replies out of order")
    require(session.is_refused or session.replied == session.asked, "a request without a reply")


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    expected = None
    if len(sys.argv) == 3:
        with open(sys.argv[2], encoding="ascii") as file:
            expected = [line for line in file.read().splitlines() if not line.startswith("#")]
    count = 0
    try:
        for line in replay(data):
            if expected is None:
                print(line)
            elif count == len(expected) or line != expected[count]:
                print(f"keyframe {count + 1}\nexpected: {expected[count] if count < len(expected) else 'none'}\nreplayed: {line}")
                return 1
            count += 1
    except ProtocolError as error:
        print(f"after {count} keyframes: {error}")
        return 1
    if expected is not None and count != len(expected):
        print(f"{count} keyframes, expected {len(expected)}")
        return 1
    print(f"{count} keyframes" + (", all as expected" if expected else ""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
