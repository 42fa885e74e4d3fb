#!/usr/bin/env python3
"""A client's decoder, written from docs/PROTOCOL.md alone: replays a recorded session and says what the client then holds.

    decoder.py STREAM              prints a line for each keyframe
    decoder.py STREAM EXPECTED     compares the lines with those of the file; exits 1 at the first that differs

A line: index, nodes of the section, nodes added, nodes removed, fingerprint, CRC-32 of the slots, CRC-32 of their heights, CRC-32 of
what the refinement test makes of them, so that the arithmetic is compared to the last bit. README.md has the layout of both files.
Only Python's standard library is used.
"""

import struct
import sys
import zlib

import wire
from section import Section
from terrain import Frame, Grid
from wire import ProtocolError, require


class Session:
    """Both directions of one session, as a client has them: sections 3 to 5."""

    def __init__(self):
        self.section = None
        self.held = self.acknowledged = 0
        self.has_asked = self.is_refused = False
        self.asked, self.replied = [], []  # ids

    def up(self, message):
        """A message that the client sent."""
        if message[0] == wire.POSE:
            update = wire.read_pose_update(message[1:])
            require(self.acknowledged <= update.received_keyframe <= self.held or self.is_refused, "an acknowledgement of nothing")
            self.acknowledged = update.received_keyframe
            return
        require(message[0] == wire.CONTROL, "not a message of this protocol")
        name, fields = wire.control(message[1:])
        require(name in wire.FROM_CLIENT, "not one that a client sends")
        require(self.has_asked or name == "ViewRequest", "a session that does not begin with a view request")
        if name == "ViewRequest":
            require(fields["protocol"] == wire.VERSION, "a client of another version")
            self.has_asked = True
        elif name != "PathUpload":
            self.asked.append((name.replace("Request", "Reply"), fields["id"]))

    def down(self, message):
        """A message that the server sent; the line of a keyframe, or None."""
        require(not self.is_refused, "a message after the refusal")
        if message[0] == wire.KEYFRAME:
            return self.take(wire.read_keyframe(message[1:]))
        require(message[0] == wire.CONTROL, "not a message of this protocol")
        name, fields = wire.control(message[1:])
        require(name in wire.BODIES and name not in wire.FROM_CLIENT, "not one that a server sends")
        if name == "Welcome":
            self.welcome(fields)
        elif name == "Refusal":
            self.is_refused = True
        else:
            self.replied.append((name, fields["id"]))
        return None

    def welcome(self, fields):
        require(self.section is None and fields["protocol"] == wire.VERSION, "a second welcome, or of another version")
        shape, corners, centres = fields["shape"], fields["corner_heights"], fields["centre_heights"]
        grid = Grid(shape)
        require(len(corners) == (grid.roots_x + 1) * (grid.roots_y + 1) and len(centres) == grid.roots_x * grid.roots_y and
                all(abs(h) <= 1 << 29 for h in corners + centres), "base heights that do not fit the shape")
        require(fields["tau_px"] > 0 and fields["keyframe_interval_us"] > 0, "no tolerance, or no interval")
        self.section = Section(grid, Frame(fields["frame"], grid.max_x, grid.max_y), corners, centres)

    def take(self, keyframe):
        require(self.section is not None, "a keyframe before the welcome")
        require(keyframe.base == self.held, "a keyframe from another one than is held")
        added, removed = self.section.step(keyframe.view, keyframe.delta)
        require(self.section.fingerprint == keyframe.fingerprint, f"another section at keyframe {keyframe.index}")
        self.held = keyframe.index
        heights = self.section.heights
        slots = sorted(heights)
        packed = [struct.pack(f"<{len(slots)}I", *slots), struct.pack(f"<{len(slots)}i", *(heights[s] for s in slots)),
                  b"".join(self.section.tests())]
        sums = " ".join(f"{zlib.crc32(data):08x}" for data in packed)
        return f"{keyframe.index} {len(slots)} {added} {removed} {keyframe.fingerprint:08x} {sums}"


def records(data):
    """(time, is it the client's, message) of a stream."""
    r = wire.Reader(data)
    require(r.take(8) == b"FLSTREAM", "not a stream")
    while r.at < len(data):
        direction, time, size = r.number("B"), r.number("q"), r.number("I")
        require(direction in (0, 1) and size > 0, "not a stream")
        yield time, direction == 0, r.take(size)


def replay(data):
    """The lines of all keyframes of a stream."""
    session = Session()
    for _, is_up, message in records(data):
        line = session.up(message) if is_up else session.down(message)
        if line:
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
