"""Range-coded data: deltas (section 11 of docs/PROTOCOL.md) and the sections that a client resumes from."""

import math

from terrain import ERROR_M
from wire import require

MOST_HEIGHT = (1 << 22) - 1


def contexts(count):
    return [[16384, 16384] for _ in range(count)]


class Number:
    def __init__(self):
        self.exponent, self.sign, self.mantissa = contexts(16), contexts(3), [contexts(4) for _ in range(8)]


class Model:
    """What both ends have learnt."""

    def __init__(self):
        self.newly_addable = [[[contexts(4) for _ in range(8)] for _ in range(16)] for _ in range(4)]
        self.addable = [[contexts(8) for _ in range(8)] for _ in range(16)]
        self.leaf = [[contexts(8) for _ in range(4)] for _ in range(2)]
        self.refused = contexts(8)
        self.height = [[[Number() for _ in range(2)] for _ in range(4)] for _ in range(28)]
        self.escape = contexts(32)
        self.radius = contexts(8)
        self.has_page = contexts(8)


class RangeDecoder:
    def __init__(self, data):
        self.data, self.at, self.range, self.code = data, 0, (1 << 32) - 1, 0
        for _ in range(4):
            self.code = self.code << 8 | self.next()

    def next(self):
        self.at += 1
        require(self.at <= len(self.data) + 4, "a delta that is cut short")
        return self.data[self.at - 1] if self.at <= len(self.data) else 0

    def normalize(self):
        while self.range < 1 << 24:
            self.code = (self.code << 8 | self.next()) & 0xFFFFFFFF
            self.range <<= 8

    def bit(self, context):
        fast, slow = context
        bound = (self.range >> 15) * min(max((fast + slow) >> 1, 256), 32512)
        if self.code < bound:
            self.range, one = bound, 1
            context[0], context[1] = fast + ((32768 - fast) >> 4), slow + ((32768 - slow) >> 7)
        else:
            self.code -= bound
            self.range, one = self.range - bound, 0
            context[0], context[1] = fast - (fast >> 4), slow - (slow >> 7)
        if self.range < 1 << 24:
            self.normalize()
        return one

    def even(self, count):
        self.range >>= count
        value = min(self.code // self.range, (1 << count) - 1)
        self.code -= value * self.range
        self.normalize()
        return value

    def tree(self, bits, c):
        at = 1
        for _ in range(bits):
            at = 2 * at + self.bit(c[at])
        return at - (1 << bits)

    def finish(self):
        require(self.at >= len(self.data), "bytes after a delta")


def half(v):
    """Halves of octaves."""
    mantissa, exponent = math.frexp(v)
    return 2 * (exponent - 1) + (1 if mantissa >= 0.75 else 0)


def keep(v, least, most):
    return min(max(v, least), most)


def read_number(coder, c, sign, escape):
    """With the contexts `c` of a number and one of its signs."""
    width = coder.tree(4, c.exponent)
    if width == 15:
        while width < 31 and coder.bit(escape[width]):
            width += 1
    if width == 0:
        return 0
    is_negative = coder.bit(c.sign[sign])
    mantissa, left, size = c.mantissa[min(width, 7)], width - 1, 1
    for at in (1, None):
        if left > 0:
            size = 2 * size + coder.bit(mantissa[at or size])
            left -= 1
    while left > 0:
        take = min(left, 12)
        left -= take
        size = size << take | coder.even(take)
    return -size if is_negative else size


class DeltaDecoder:
    """Reads decisions, heights and radii. `height_of(x, y)` and `displacement_of(x, y)` return what is held; the latter is 0 for base
    vertices."""

    def __init__(self, coder, model, grid, height_quantum_m, height_of, displacement_of):
        self.coder, self.model, self.grid = coder, model, grid
        self.height_of, self.displacement_of = height_of, displacement_of
        self.quanta = [m * (1 / height_quantum_m) for m in ERROR_M]
        self.before = self.pages_before = 0

    def begin_group(self):
        self.before = 0

    def prediction_context(self, n):
        ends = sum(self.height_of(*v) for v in n.endpoints)
        difference = sum(self.height_of(*v) for v in n.apexes)
        displacements = [self.displacement_of(*v) for v in n.apexes]
        if len(n.apexes) == 1:
            difference, displacements = 2 * difference, 2 * displacements
        difference -= ends
        curve, magnitude = difference + sum(displacements), sum(map(abs, displacements))
        return ends, curve, 0.25 * (2 * magnitude + abs(difference)) + 0.25

    def are_refused(self, count):
        """So many nodes of a page."""
        return self.coder.bit(self.model.refused[min(count.bit_length() - 1, 7)])

    def decision_of_leaf(self, n, is_new, bound, least):
        own = abs(self.displacement_of(n.x, n.y)) + 0.25
        size = keep(half(own / self.quanta[least]) + 5, 0, 7)
        return self.coder.bit(self.model.leaf[1 if is_new else 0][min(least - bound - 1, 3)][size])

    def decision_of_addable(self, n, bound, least, familiarity, finest):
        """`familiarity` is None of a node that is not new."""
        size = keep(half(self.prediction_context(n)[2] / self.quanta[least]) + 8, 0, 15)
        scale = min((self.grid.last_level - n.level) >> 1, 7)
        if familiarity is None:
            return self.coder.bit(self.model.addable[size][min(bound - least, 7)][scale])
        detail = scale if familiarity == 0 else min(abs(finest - least), 7)
        decision = self.coder.bit(self.model.newly_addable[familiarity][size][detail][self.before])
        self.before = (2 * self.before + decision) & 3
        return decision

    def height(self, n, least):
        ends, curve, expected = self.prediction_context(n)
        quanta = self.quanta[least]
        scale = keep(half(max(quanta, expected)) + 4, 0, 27)
        at = half(expected / quanta)
        curved = 1 if 2 * abs(curve) >= quanta else 0
        sign = 0 if not curved else 1 if curve < 0 else 2
        contexts_of = self.model.height[scale][sum(edge <= at for edge in (-2, 0, 2))][curved]
        height = ((8 * ends + 3 * curve + 8) >> 4) + read_number(self.coder, contexts_of, sign, self.model.escape)
        require(abs(height) <= MOST_HEIGHT, "an absurd height")
        return height

    def has_page(self):
        is_there = self.coder.bit(self.model.has_page[self.pages_before])
        self.pages_before = (2 * self.pages_before + is_there) & 7
        return is_there

    def radius(self):
        value = self.coder.tree(3, self.model.radius)
        return min(value + self.coder.even(8), 127) if value == 7 else value


def section_contexts():
    """The contexts of the sections of a resume message: [level][before], and last those of pages."""
    return [contexts(8) for _ in range(32)]


class PageBits:
    """Which pages of sparse levels have a node of a section; those of nodes that are `sure` unasked."""

    def __init__(self, coder, model, sure):
        self.coder, self.model, self.before, self.sure = coder, model[-1], 0, {slot >> 8 for slot in sure}

    def has_any(self, page):
        if page in self.sure:
            return True
        bit = self.coder.bit(self.model[self.before])
        self.before = (2 * self.before + bit) & 7
        return bit


def read_section(coder, model, last_level, first_level, children, sure=frozenset(), whole_levels=31):
    """The slots of a section in a resume message, those that are `sure` unasked. `children(slots)` are those that have all their
    parents among them and one at least on the last level of these."""
    slots, candidates, pages = set(), first_level, PageBits(coder, model, sure)
    for level in range(1, last_level + 1):
        before, included, asked = 0, set(), {}
        for slot in sorted(candidates):
            if level > whole_levels:
                if slot >> 8 not in asked:
                    asked[slot >> 8] = pages.has_any(slot >> 8)
                if not asked[slot >> 8]:
                    continue
            decision = 1 if slot in sure else coder.bit(model[level][before])
            before = (2 * before + decision) & 7
            if decision:
                included.add(slot)
        slots |= included
        candidates = children(slots, included)
    return slots


def read_sections(data, grid, surfaces):
    """The terrain's section, one for each object's surface, the terrain's known nodes, and the finest errors of their pages."""
    coder = RangeDecoder(data)
    nodes = {n.slot: n for n in grid.first_level()}

    def children_in_grid(slots, included):
        below = {c.slot: c for s in included for c in (grid.node(*v) for v in nodes[s].children) if slots.issuperset(c.parents)}
        nodes.update(below)
        return set(below)
    terrain = read_section(coder, section_contexts(), grid.last_level, set(nodes), children_in_grid, whole_levels=grid.last_whole_level)
    model, objects = section_contexts(), []
    for surface in surfaces:
        def children(slots, included):
            return {c for s in included for c in surface.children(s) if slots.issuperset(surface.nodes[c].parents)}
        objects.append(read_section(coder, model, surface.last_level, set(surface.first_level), children))
    known = read_section(coder, section_contexts(), grid.last_level, {n.slot for n in grid.first_level()}, children_in_grid, terrain,
                         grid.last_whole_level)
    number, escape, finest, before = Number(), contexts(32), {}, 49
    for page in sorted({slot >> 8 for slot in known}):
        finest[page] = before = keep(before + read_number(coder, number, 0, escape), 0, 255)
    coder.finish()
    return terrain, objects, known, finest
