"""Ground that moves in time: section 17 of docs/PROTOCOL.md."""

import struct

from coder import Number, contexts, read_number
from wire import require

MOST_OFFSET = 2 * ((1 << 22) - 1)
MOST_BLOCKS = 16384
LINEAR, CATMULL_ROM, B_SPLINE = range(3)


class Epochs:
    """What is known of the offsets of a scene's vertices; nothing happens in a scene without epochs."""

    def __init__(self, grid, shape, epochs, base_offsets, corners, blend):
        require(blend in (LINEAR, CATMULL_ROM, B_SPLINE), "an unknown blend")
        self.blend = blend
        self.grid, self.last = grid, (shape["samples_x"] - 1, shape["samples_y"] - 1)
        self.times = [e[0] for e in epochs]
        self.windows = [e[1:] for e in epochs]
        require(all(a < b for a, b in zip(self.times, self.times[1:])), "epochs out of order")
        require(all(x + w <= self.last[0] + 1 and y + h <= self.last[1] + 1 for x, y, w, h in self.windows), "a window beyond the data")
        self.base = {(epoch, vertex): quanta for epoch, vertex, quanta in base_offsets}
        self.corners = corners
        self.begin_anew()

    def begin_anew(self):
        self.known = [{} for _ in self.times]  # offsets by slot
        self.bits, self.escape = contexts(3), contexts(32)
        self.numbers = [[Number() for _ in range(5)] for _ in range(10)]
        self.time = self.step_us = 0
        self.blended = None

    def may_move(self, epoch, x, y):
        left, low, width, height = self.windows[epoch]
        x, y = min(x, self.last[0]), min(y, self.last[1])
        return left <= x < left + width and low <= y < low + height

    def vertex_number(self, x, y):
        size = 1 << self.grid.k
        if x % size == 0 and y % size == 0:
            return y // size * (self.grid.roots_x + 1) + x // size
        return self.corners + y // size * self.grid.roots_x + x // size

    def find(self, epoch, x, y):
        """None if it is not known."""
        if not self.may_move(epoch, x, y):
            return 0
        if self.grid.is_base(x, y):
            return self.base.get((epoch, self.vertex_number(x, y)), 0)
        return self.known[epoch].get(self.grid.slot(x, y))

    def nearest(self, epoch, x, y):
        order = sorted(range(len(self.times)), key=lambda k: (abs(k - epoch), k))
        return next(k for k in order if self.find(k, x, y) is not None)

    def offset(self, epoch, x, y):
        return self.find(self.nearest(epoch, x, y), x, y)

    def blend_at(self, time):
        require(self.times[0] <= time <= self.times[-1], "a time of no epoch")
        before, last = max(i for i, t in enumerate(self.times) if t <= time), len(self.times) - 1
        if self.times[before] == time:
            is_between = self.blend == B_SPLINE and 0 < before < last
            return [before - 1, before, before + 1] if is_between else [before]
        more = 0 if self.blend == LINEAR else 1
        return list(range(max(0, before - more), min(last, before + 1 + more) + 1))

    def take(self, nodes, coder):
        """`nodes` of the section, by ascending slot: (slot, node)."""
        if not self.times:
            return
        time = self.time + self.step_us
        if not coder.bit(self.bits[0]):
            time = self.time
            if not coder.bit(self.bits[1]):
                time = 0
                for _ in range(4):
                    time = time << 16 | coder.even(16)
                time -= (time >> 63) << 64
        if self.blend != LINEAR:
            coder.bit(self.bits[2])  # a step or a jump: it matters to what is said of frames only
        blended = self.blend_at(time)
        if blended != self.blended:
            self.forget(blended)
        for epoch in blended:
            self.take_epoch(epoch, nodes, coder)
        self.step_us = 0 if self.blended is None else time - self.time
        self.time, self.blended = time, blended

    def take_epoch(self, epoch, nodes, coder):
        before = 0
        for slot, n in nodes:
            if self.find(epoch, n.x, n.y) is not None:
                continue
            k = self.nearest(epoch, n.x, n.y)
            a, b = (self.offset(epoch, *v) - self.offset(k, *v) for v in n.endpoints)
            activity = min(9, max(abs(a).bit_length(), abs(b).bit_length()) + (1 if a != b else 0))
            sign = 0 if a + b == 0 else 1 if a + b < 0 else 2
            difference = read_number(coder, self.numbers[activity][before], sign, self.escape)
            value = self.find(k, n.x, n.y) + ((a + b) >> 1) + difference
            require(abs(value) <= MOST_OFFSET, "an absurd offset")
            self.known[epoch][slot] = value
            before = min(4, abs(difference).bit_length())

    def forget(self, blended):
        if sum(len({slot >> 6 for slot in known}) for known in self.known) <= MOST_BLOCKS:
            return
        for epoch, known in enumerate(self.known):
            if epoch not in blended and epoch not in (self.blended or []):
                known.clear()

    def packed(self, nodes):
        """The scene time, then the offsets of the section's nodes at the epochs that are blended."""
        offsets = [self.offset(epoch, n.x, n.y) for epoch in self.blended for _, n in nodes]
        return [struct.pack(f"<q{len(offsets)}i", self.time, *offsets)]
