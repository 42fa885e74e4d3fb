"""A recorded session (tests/protocol/golden) replayed for the figures: what the client holds at each keyframe, and what each step read.

The replay is the Python decoder's of tests/protocol, so the sections, heights and bytes are those that today's server sends.
"""

import math
import os
import sys
from dataclasses import dataclass

import source_files

sys.path.insert(0, os.path.join(source_files.ROOT, "tests", "protocol"))

import decoder  # noqa: E402
import section as steps  # noqa: E402
import wire  # noqa: E402

MOST_BITS = 15  # of a probability


@dataclass
class Call:
    """Symbols of one kind that a step read for nodes of one level, one after another."""
    kind: str  # decision, height or radius
    level: int
    is_removal: bool
    count: int
    bits: float


@dataclass
class Keyframe:
    index: int
    time_s: float
    view: wire.View
    heights: dict  # of the section's nodes, by slot
    bounds: dict  # quantised errors of the frontier's nodes, by slot
    spheres: dict  # likewise
    calls: list


class Flight:
    def __init__(self, name):
        self.session = decoder.Session()
        self.keyframes, self.poses = [], []
        self.calls, self.is_removal, self.bits = [], False, 0.0
        self.watch()
        with open(os.path.join(source_files.ROOT, "tests", "protocol", "golden", name + ".stream"), "rb") as file:
            for what, message in decoder.records(file.read()):
                self.play(what, message)

    @property
    def grid(self):
        return self.session.section.grid

    @property
    def section(self):
        return self.session.section

    def play(self, what, message):
        if what == decoder.NEW_CONNECTION:
            self.session.connect()
        elif what == decoder.FROM_CLIENT:
            self.session.up(message)
        else:
            self.calls = []
            if self.session.down(message):
                self.keep(self.session.keyframes.last)

    def keep(self, keyframe):
        s = self.session.section
        self.keyframes.append(Keyframe(keyframe.index, keyframe.time / 1e6, keyframe.view,
                                       {slot: s.heights[slot] for slot in s.slots}, dict(s.bounds),
                                       dict(s.spheres), self.calls))

    def watch(self):
        """Has the decoder tell of the poses that went up and of each symbol that a step reads."""
        flight = self

        class Watched(steps.DeltaDecoder):
            def radius(self):
                return flight.measure("radius", flight.level, super().radius)

            def height(self, n, least):
                return flight.measure("height", n.level, lambda: super(Watched, self).height(n, least))

            def are_refused(self, count):
                return flight.measure("decision", flight.level, lambda: super(Watched, self).are_refused(count))

            def decision_of_leaf(self, n, is_new, bound, least):
                return flight.measure("decision", n.level, lambda: super(Watched, self).decision_of_leaf(n, is_new, bound, least))

            def decision_of_addable(self, n, *known):
                return flight.measure("decision", n.level, lambda: super(Watched, self).decision_of_addable(n, *known))

        class WatchedSection(decoder.Section):
            def remove(self, level, leaves):
                flight.is_removal, flight.level = True, level
                return super().remove(level, leaves)

            def add(self, level, addable, arriving):
                flight.is_removal, flight.level = False, level
                return super().add(level, addable, arriving)

            def tests(self):  # only needed to compare with the golden expectations
                return iter(())

        class WatchedCoder(decoder.RangeDecoder):
            def bit(self, context):
                chance = min(max(sum(context) >> 1, 256), 32512) / (1 << MOST_BITS)
                got = super().bit(context)
                flight.bits -= math.log2(chance if got else 1 - chance)
                return got

            def even(self, count):
                flight.bits += count
                return super().even(count)

        steps.DeltaDecoder, decoder.Section, decoder.RangeDecoder = Watched, WatchedSection, WatchedCoder
        pose = decoder.Session.pose

        def tell_pose(session, update):
            flight.poses.append((update.time / 1e6, update.pose))
            pose(session, update)
        decoder.Session.pose = tell_pose

    def measure(self, kind, level, read):
        before = self.bits
        result = read()
        last = self.calls[-1] if self.calls else None
        if last and (last.kind, last.level, last.is_removal) == (kind, level, self.is_removal):
            last.count, last.bits = last.count + 1, last.bits + self.bits - before
        else:
            self.calls.append(Call(kind, level, self.is_removal, 1, self.bits - before))
        return result

    # ---- geometry

    def position(self, x, y, height=0):
        return self.section.frame.position(x, y, height)

    def height_in(self, keyframe, x, y):
        """Of a vertex, in quanta, in the section of a keyframe; of a node outside it the middle of its edge."""
        if self.grid.is_base(x, y):
            return self.section.height_of(x, y)
        slot = self.grid.slot(x, y)
        if slot in keyframe.heights:
            return keyframe.heights[slot]
        (a, b), (c, d) = self.grid.node(x, y).endpoints
        return 0.5 * (self.height_in(keyframe, a, b) + self.height_in(keyframe, c, d))

    def triangles(self, slots):
        """((x, y) * 3, level) of the mesh of a closed set of slots."""
        side = 1 << self.grid.k
        half = side // 2
        for y in range(0, self.grid.max_y, side):
            for x in range(0, self.grid.max_x, side):
                ring = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
                for i in range(4):
                    yield from self.refined(ring[i], ring[(i + 1) % 4], (x + half, y + half), 0, slots)

    def refined(self, a, b, apex, level, slots):
        """Halves the edge a-b if its middle is a node of `slots`."""
        middle = (a[0] + b[0]) // 2, (a[1] + b[1]) // 2
        if level < self.grid.last_level and self.grid.slot(*middle) in slots:
            yield from self.refined(apex, a, middle, level + 1, slots)
            yield from self.refined(b, apex, middle, level + 1, slots)
        else:
            yield (a, b, apex), level
