"""The sections of objects and what is sent of them: section 15 of docs/PROTOCOL.md."""

import copy
import struct

from coder import contexts, read_number
from section import bits_f64, f64_bits, fingerprint, least
from surface import Bounds, Record, Surface, SurfaceTest
from wire import Pose, require


class Number:
    def __init__(self):
        self.exponent, self.sign, self.mantissa = contexts(16), contexts(1), [contexts(4) for _ in range(8)]


class RecordModel:
    """What both ends have learnt, of all objects."""

    def __init__(self):
        self.displacement, self.normal = ([Number() for _ in range(16)] for _ in range(2))
        self.radius, self.along, self.across, self.cone, self.bulge = ([Number(), Number()] for _ in range(5))
        self.escape = contexts(32)


def towards_zero(a, b):
    return -(-a // b) if a < 0 else a // b


class RecordDecoder:
    """Of one object, in one delta."""

    def __init__(self, surface, records, model, coder):
        self.surface, self.records, self.model, self.coder = surface, records, model, coder

    def position(self, vertex):
        if isinstance(vertex, tuple):
            return self.records[self.surface.slot(vertex)].position
        return self.surface.base[vertex]

    def middle(self, slot):
        return [(a + b) >> 1 for a, b in zip(*(self.position(v) for v in self.surface.nodes[slot].endpoints))]

    def read(self, slot):
        parents = self.surface.nodes[slot].parents
        of = [self.records[p] for p in parents]
        moved = [[a - b for a, b in zip(r.position, self.middle(p))] for p, r in zip(parents, of)]
        displacement = [towards_zero(sum(axis), 4 * len(of)) for axis in zip(*moved)] if of else [0, 0, 0]
        size = max(abs(v) for v in displacement)
        normal = [towards_zero(sum(axis), len(of)) for axis in zip(*(r.normal for r in of))] if of else [0, 0]
        likely = {key: max((getattr(r, key) for r in of), default=0) for key in ("radius", "along", "across", "cone", "bulge")}
        m, p, r = self.model, 1 if of else 0, Record()
        r.position = tuple(self.number(m.displacement[min(size.bit_length(), 15)], a + b, -1 << 28, 1 << 28)
                           for a, b in zip(self.middle(slot), displacement))
        turn = m.normal[1 + min(likely["cone"] // 20, 14) if of else 0]
        r.normal = tuple(self.number(turn, v, -32768, 32767) for v in normal)
        r.radius = self.bound(m.radius[p], likely["radius"] - 256)
        r.along = self.bound(m.along[p], likely["along"] - 512)
        r.across = self.bound(m.across[p], r.along + likely["across"] - likely["along"])
        r.cone = self.number(m.cone[p], 2 * likely["cone"] // 3, 0, 255)
        r.bulge = self.number(m.bulge[p], 2 * likely["bulge"] // 3, 0, 255)
        return r

    def bound(self, c, expected):
        return self.number(c, max(expected, 0), 0, 0xFE00)

    def number(self, c, expected, lowest, highest):
        value = expected + read_number(self.coder, c, 0, self.model.escape)
        require(lowest <= value <= highest, "an absurd record")
        return value


class ObjectSection:
    """What a client holds of one object, and its step."""

    def __init__(self, surface, placement, weight):
        self.surface, self.placement, self.weight = surface, placement, weight
        self.slots, self.frontier = set(), set()
        self.records, self.bounds = {}, {}  # of both, by slot
        self.is_first = True
        self.print = 0  # what it adds to the fingerprint

    def step(self, view, model, coder):
        """To the section of `view`; returns how many nodes came and went."""
        self.test = SurfaceTest(self.surface, self.placement, view)
        self.decoder = RecordDecoder(self.surface, self.records, model, coder)
        levels = range(1, self.surface.last_level + 1)
        going, coming = ([set() for _ in range(self.surface.last_level + 2)] for _ in range(2))
        for slot in self.frontier:
            is_leaf = slot in self.slots
            if self.passes(slot) != is_leaf:
                (going if is_leaf else coming)[self.surface.nodes[slot].level].add(slot)
        removed = sum(self.remove(level, going) for level in reversed(levels))
        arriving = [set() for _ in range(self.surface.last_level + 2)]
        if self.is_first:
            self.is_first = False
            arriving[1].update(self.surface.first_level)
        added = sum(self.add(level, coming[level] & self.frontier, arriving) for level in levels)
        for slot in [s for s in self.records if s not in self.slots and s not in self.frontier]:
            del self.records[slot], self.bounds[slot]
        return added, removed

    def passes(self, slot):
        return self.test.passes(self.bounds[slot])

    def remove(self, level, going):
        gone = [slot for slot in going[level] if not self.passes(slot)]
        self.slots.difference_update(gone)
        for slot in gone:
            self.print -= self.weight * fingerprint(slot)
            self.frontier.difference_update(self.surface.children(slot))
            for parent in self.surface.nodes[slot].parents:
                if self.slots.isdisjoint(self.surface.children(parent)):
                    self.frontier.add(parent)
                    going[level - 1].add(parent)
        return len(gone)

    def add(self, level, coming, arriving):
        for slot in sorted(arriving[level]):
            self.records[slot] = self.decoder.read(slot)
            self.bounds[slot] = Bounds(self.records[slot], self.surface.step_m)
        self.frontier |= arriving[level]
        come = [slot for slot in coming | arriving[level] if self.passes(slot)]
        self.slots.update(come)
        for slot in come:
            self.print += self.weight * fingerprint(slot)
            self.frontier.difference_update(self.surface.nodes[slot].parents)
            arriving[level + 1].update(child for child in self.surface.children(slot)
                                       if self.slots.issuperset(self.surface.nodes[child].parents))
        return len(come)

    def tests(self):
        """What the last view's test makes of the section's nodes, as bytes: front and back; and of some nodes the least radius
        that meets the view and the least error across that passes."""
        for slot in sorted(self.slots):
            n = self.bounds[slot]
            yield struct.pack("<dd", *self.test.seen(n)[2:4])
            if slot % 8 == 0:
                yield struct.pack("<dd", *self.least_numbers(n))

    def least_numbers(self, n):
        most, changed = f64_bits(1e30), copy.copy(n)
        changed.along = 0.0

        def is_seen(bits):
            changed.across = bits_f64(bits)
            return self.test.passes(changed)
        radius = least(lambda bits: self.test.meets_frustum(n, bits_f64(bits)), most)
        return bits_f64(radius), bits_f64(least(is_seen, most))


class Objects:
    """All objects of a scene, from the welcome on."""

    def __init__(self, models, placements):
        require(len(models) <= 1024 and len(placements) <= 4096, "too many models, or objects")
        surfaces = [Surface(m) for m in models]
        for p in placements:
            require(p["model"] < len(surfaces) and Pose(p["position"], p["orientation"]).is_usable() and 1e-6 <= p["scale"] <= 1e6,
                    "an object of no model, or nowhere")
        self.begin = lambda: [ObjectSection(surfaces[p["model"]], p, 2 * i + 3) for i, p in enumerate(placements)]
        self.begin_anew()

    def begin_anew(self):
        """After a keyframe from 0, as on every connection."""
        self.sections, self.model = self.begin(), RecordModel()

    def step(self, view, coder):
        self.changes = [s.step(view, self.model, coder) for s in self.sections]

    def fingerprint(self):
        return sum(s.print for s in self.sections)

    def counts(self):
        """Nodes of all sections, and how many of them came and went in the last step."""
        return sum(len(s.slots) for s in self.sections), *(sum(change) for change in zip(*self.changes))

    def packed(self):
        """Slots, records and tests of all, as bytes."""
        slots = b"".join(struct.pack(f"<{1 + len(s.slots)}I", len(s.slots), *sorted(s.slots)) for s in self.sections)
        records = b"".join(struct.pack("<iiiHHHBBhh", *r.position, r.radius, r.along, r.across, r.cone, r.bulge, *r.normal)
                           for s in self.sections for r in (s.records[slot] for slot in sorted(s.slots)))
        return slots, records, b"".join(test for s in self.sections for test in s.tests())
