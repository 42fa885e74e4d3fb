"""The sections of objects and what is sent of them: section 15 of docs/PROTOCOL.md."""

import struct

from coder import contexts, read_number
from section import Test, dot, fingerprint, rotate
from surface import Surface
from wire import Pose, require

MOST_NODES, MOST_STEPS = 1 << 24, 1 << 28
GOES, COMES = 0, 1


class Number:
    def __init__(self):
        self.exponent, self.sign, self.mantissa = contexts(16), contexts(1), [contexts(4) for _ in range(8)]


class ObjectModel:
    """What both ends have learnt, of all objects."""

    def __init__(self):
        self.changes = contexts(4)
        self.blocks = [[contexts(4) for _ in range(8)] for _ in range(2)]
        self.removed = self.of_nodes()
        self.added = [[self.of_nodes() for _ in range(4)] for _ in range(2)]
        self.position, self.move = [[[Number() for _ in range(16)] for _ in range(4)] for _ in range(2)]
        self.escape = contexts(32)

    @staticmethod
    def of_nodes():
        return [[contexts(8) for _ in range(5)] for _ in range(4)]


def towards_zero(a, b):
    return -(-a // b) if a < 0 else a // b


def product(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3], a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1])


class ViewContext(Test):
    """An object as a view has it."""

    def __init__(self, surface, placement, view):
        position, (w, x, y, z), scale = placement["position"], placement["orientation"], placement["scale"]
        back = w, -x, -y, -z
        offset = tuple(a - b for a, b in zip(view.pose.eye, position))
        self.see(tuple(v / scale for v in rotate(back, offset)), product(back, view.pose.orientation), view)
        per_metre = 0.5 * view.height / self.tan_y / view.tau
        self.looks, self.quantum_m = per_metre * per_metre, surface.quantum_m
        self.tan_x = self.tan_y * view.width / view.height

    def offset(self, position):
        return tuple(p * self.quantum_m - e for p, e in zip(position, self.eye))

    def size(self, o):
        return self.looks / (o[0] * o[0] + o[1] * o[1] + o[2] * o[2] + self.quantum_m * self.quantum_m)

    def screen(self, o):
        depth = dot(o, self.forward)
        if not depth > 0:
            return 7
        out = max(abs(dot(o, self.right)) / self.tan_x, abs(dot(o, self.up)) / self.tan_y) / depth
        return sum(out >= edge for edge in (0.6, 0.85, 0.95, 1.05, 1.2, 1.5))


class KnownNodes:
    """Of one model: (position, displacement, moves) by slot, and in how many sections each is."""

    def __init__(self):
        self.nodes, self.uses = {}, {}

    def forget(self):
        self.nodes = {slot: n for slot, n in self.nodes.items() if slot in self.uses}

    def use(self, slot, more):
        self.uses[slot] = self.uses.get(slot, 0) + more
        if not self.uses[slot]:
            del self.uses[slot]


class ObjectSection:
    """What a client holds of one object, and its step."""

    def __init__(self, surface, placement, known, weight):
        self.surface, self.placement, self.known, self.weight = surface, placement, known, weight
        self.slots = set()
        self.has_changed = 0
        self.print = 0  # what it adds to the fingerprint

    def begin_anew(self):
        self.has_changed = 0

    def position(self, vertex):
        if isinstance(vertex, tuple):
            return self.known.nodes[self.surface.slot(vertex)][0]
        return self.surface.base[vertex]

    def moves(self, vertex):
        if isinstance(vertex, tuple):
            return self.known.nodes[self.surface.slot(vertex)][2]
        return self.surface.base_moves[vertex]

    def middle(self, slot):
        return [(a + b) >> 1 for a, b in zip(*(self.position(v) for v in self.surface.nodes[slot].endpoints))]

    def step(self, view, last, model, coder):
        """To the section of a keyframe; returns how many nodes were added and removed."""
        self.model, self.coder = model, coder
        self.now = ViewContext(self.surface, self.placement, view)
        self.before = last and ViewContext(self.surface, self.placement, last)
        self.added, self.removed = set(), set()
        self.has_changed = coder.bit(model.changes[2 * self.has_changed + (1 if self.slots else 0)])
        if self.has_changed:
            levels = range(1, self.surface.last_level + 1)
            for level in reversed(levels):
                self.walk(GOES, self.leaves(level))
            for level in levels:
                self.walk(COMES, self.addable(level))
        return len(self.added), len(self.removed)

    def leaves(self, level):
        return [s for s in self.slots if self.surface.nodes[s].level == level and self.slots.isdisjoint(self.surface.children(s))]

    def addable(self, level):
        if level == 1:
            slots = set(self.surface.first_level)
        else:
            slots = {c for s in self.slots if self.surface.nodes[s].level == level - 1 for c in self.surface.children(s)
                     if self.slots.issuperset(self.surface.nodes[c].parents)}
        return slots - self.slots - self.removed

    def walk(self, change, candidates):
        blocks = {}
        for slot in sorted(candidates):
            blocks.setdefault(slot >> 6, []).append(slot)
        before = 0
        for block in blocks.values():
            any_changes = self.coder.bit(self.model.blocks[change][len(block).bit_length()][before])
            before = (2 * before + any_changes) & 3
            if any_changes:
                self.walk_block(change, block)

    def walk_block(self, change, block):
        is_first = True
        for slot in block:
            if is_first and slot == block[-1] or self.coder.bit(self.context(change, slot)):
                is_first = False
                self.go(slot) if change == GOES else self.arrive(slot)

    def context(self, change, slot):
        n, middle = self.surface.nodes[slot], self.middle(slot)
        offset = self.now.offset(middle)
        trend = 2
        if self.before:
            grown = self.now.size(offset) / self.before.size(self.before.offset(middle))
            trend = sum(grown >= edge for edge in (0.95, 0.995, 1.005, 1.05))
        of_nodes = self.model.removed
        if change == COMES:
            siblings = sum(c in self.slots for p in n.parents for c in self.surface.children(p))
            of_nodes = self.model.added[0 if self.added.isdisjoint(n.parents) else 1][min(siblings, 3)]
        return of_nodes[min(n.level, 4) - 1][trend][self.now.screen(offset)]

    def go(self, slot):
        self.slots.remove(slot)
        self.removed.add(slot)
        self.print -= self.weight * fingerprint(slot)
        self.known.use(slot, -1)

    def arrive(self, slot):
        if slot not in self.known.nodes:
            self.known.nodes[slot] = self.read_position(slot)
        self.known.use(slot, 1)
        self.slots.add(slot)
        self.added.add(slot)
        self.print += self.weight * fingerprint(slot)

    def read_position(self, slot):
        middle = self.middle(slot)
        of = [self.known.nodes[p][1] for p in self.surface.nodes[slot].parents]
        count, most, position = max(len(of), 1), 0, []
        bends = [sum(abs(d[axis]) for d in of) for axis in range(3)]
        for axis in range(3):
            guess = middle[axis] + towards_zero(sum(d[axis] for d in of), 4 * count)
            like = (sum(bends) + 3 * bends[axis]) // (4 * count)
            prior = 0 if axis == 0 else 1 if most * 8 < like else 2 if most * 3 < like else 3
            off = read_number(self.coder, self.model.position[prior][min(like.bit_length(), 15)], 0, self.model.escape)
            most = max(most, abs(off))
            require(abs(guess + off) <= MOST_STEPS, "an absurd position")
            position.append(guess + off)
        return tuple(position), tuple(a - b for a, b in zip(position, middle)), self.read_moves(slot, position)

    def read_moves(self, slot, position):
        moves, beside = [], (0, 0, 0)
        for a, b in zip(*(self.moves(v) for v in self.surface.nodes[slot].endpoints)):
            middle = [(x + y) >> 1 for x, y in zip(a, b)]
            like = sum(4 * abs(d) for d in beside) + sum(abs(x - y) for x, y in zip(a, b))
            most, move = 0, []
            for axis in range(3):
                guess = max(-2 * MOST_STEPS, min(2 * MOST_STEPS, middle[axis] + beside[axis]))
                prior = 0 if axis == 0 else 1 if most == 0 else 2 if most * 8 < like else 3
                off = read_number(self.coder, self.model.move[prior][min(like.bit_length(), 15)], 0, self.model.escape)
                most = max(most, abs(off))
                require(abs(position[axis] + guess + off) <= MOST_STEPS, "an absurd move")
                move.append(guess + off)
            moves.append(tuple(move))
            beside = tuple(x - y for x, y in zip(move, middle))
        return moves


class Objects:
    """All objects of a scene, from the welcome on."""

    def __init__(self, models, placements, epochs, blend):
        """In a scene of so many epochs, which are blended so."""
        require(len(models) <= 1024 and len(placements) <= 4096, "too many models, or objects")
        surfaces = [Surface(m, epochs, blend) for m in models]
        for p in placements:
            require(p["model"] < len(surfaces) and Pose(p["position"], p["orientation"]).is_usable() and 1e-6 <= p["scale"] <= 1e6,
                    "an object of no model, or nowhere")
        self.surfaces, self.placements = surfaces, placements
        self.begin_from_nothing()

    def begin_from_nothing(self):
        """After a keyframe from 0."""
        self.known = [KnownNodes() for _ in self.surfaces]
        self.sections = [ObjectSection(self.surfaces[p["model"]], p, self.known[p["model"]], 2 * i + 3)
                         for i, p in enumerate(self.placements)]
        self.begin_anew()

    def begin_anew(self):
        """With the sections that are held, as on a new connection."""
        self.model, self.last = ObjectModel(), None
        for known in self.known:
            known.forget()
        for section in self.sections:
            section.begin_anew()

    def step(self, view, coder, memory_bytes):
        for known in self.known:
            if len(known.nodes) > 2 * len(known.uses) + 1024 + memory_bytes // (512 * len(self.known)):
                known.forget()
        self.changes = [s.step(view, self.last, self.model, coder) for s in self.sections]
        self.last = view
        require(sum(len(s.slots) for s in self.sections) <= MOST_NODES, "too many nodes")

    def fingerprint(self):
        return sum(s.print for s in self.sections)

    def counts(self):
        """Nodes of all sections, and how many the last step added and removed."""
        return sum(len(s.slots) for s in self.sections), *(sum(change) for change in zip(*self.changes))

    def packed(self):
        """Slots, and positions and moves of all, as bytes."""
        slots = b"".join(struct.pack(f"<{1 + len(s.slots)}I", len(s.slots), *sorted(s.slots)) for s in self.sections)
        nodes = [s.known.nodes[slot] for s in self.sections for slot in sorted(s.slots)]
        return slots, b"".join(struct.pack("<iii", *v) for position, _, moves in nodes for v in (position, *moves))
