"""The refinement test and the step from keyframe to keyframe: sections 9 and 10 of docs/PROTOCOL.md."""

import itertools
import math
import struct

from coder import DeltaDecoder, Model
from terrain import ERROR_M, RADIUS_FACTOR, f32, flat_radii, sin_cos
from wire import require

MOST_NODES = 1 << 24
NONE = 256  # no class passes


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]


def rotate(q, v):
    w, u = q[0], q[1:]
    uv = cross(u, v)
    uuv = cross(u, uv)
    return tuple(v[i] + ((uv[i] * w) + uuv[i]) * 2 for i in range(3))


def least(passes, most):
    """The least whole number, from 0, that passes; larger ones pass too. `most` if none below it does."""
    if passes(0):
        return 0
    low, high = 0, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if passes(middle) else (middle, high)
    return high


def f64_bits(x):
    return struct.unpack("<Q", struct.pack("<d", x))[0]


def bits_f64(bits):
    return struct.unpack("<d", struct.pack("<Q", bits))[0]


class Test:
    """Section 9, of one view."""

    def __init__(self, frame, view):
        self.frame = frame
        self.see(view.pose.eye, view.pose.orientation, view)
        self.scale = 0.5 * view.height / self.tan_y / view.tau
        if frame.is_planar:
            a, b, h = (*frame.axis_x_m, 0.0), (*frame.axis_y_m, 0.0), (0.0, 0.0, frame.height_quantum_m)
            o = tuple(-frame.anchor[0] * a[i] - frame.anchor[1] * b[i] - self.eye[i] for i in range(3))
            rows = self.right, self.up, self.forward, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
            self.rows = [(dot(r, a), dot(r, b), dot(r, h), dot(r, o)) for r in rows]
        self.horizon = Horizon(self) if frame.is_globe else None

    def see(self, eye, orientation, view):
        """From there, with the lens and region of the view."""
        self.eye = eye
        self.right, self.up, self.forward = (rotate(orientation, v) for v in ((1, 0, 0), (0, 1, 0), (0, 0, -1)))
        sin_f, cos_f = sin_cos(0.5 * view.fov)
        self.tan_y = tan_y = sin_f / cos_f
        tan_x = tan_y * view.width / view.height
        self.cos_x, self.cos_y = 1 / math.sqrt(1 + tan_x * tan_x), 1 / math.sqrt(1 + tan_y * tan_y)
        self.sin_x, self.sin_y = tan_x * self.cos_x, tan_y * self.cos_y
        self.corner = math.sqrt(1 + tan_x * tan_x + tan_y * tan_y)
        self.cos_corner = 1 / self.corner
        self.region_radius = view.region_radius
        self.sin_w, self.cos_w = sin_cos(min(view.region_angle, 1.5))

    def view_position(self, sphere):
        x, y, middle, position, _ = sphere
        if self.frame.is_planar:
            px, py, pz, e, n = (a * x + b * y + h * middle + o for a, b, h, o in self.rows)
            return px, py, pz, math.sqrt(e * e + n * n)
        p = position[0] - self.eye[0], position[1] - self.eye[1], position[2] - self.eye[2]
        return dot(p, self.right), dot(p, self.up), dot(p, self.forward), math.sqrt(p[0] * p[0] + p[1] * p[1])

    def facing(self, x, y, z):
        side = min(z * self.sin_x - abs(x) * self.cos_x, z * self.sin_y - abs(y) * self.cos_y)
        return side * self.cos_w + math.sqrt(max(0.0, (x * x + y * y + z * z) - side * side)) * self.sin_w

    def depth(self, x, y, z, R, nearest):
        rho2 = x * x + y * y
        d = math.sqrt(rho2 + z * z)
        return max((z * self.cos_w - math.sqrt(rho2) * self.sin_w) - R, (d - R) * self.cos_corner, nearest)

    def of(self, position, radius):
        """passes(error in metres) for a sphere, or None if it is out of view, so that no error passes."""
        x, y, z, h = position
        R = radius + self.region_radius
        if not self.facing(x, y, z) + R >= 0:
            return None
        if self.horizon and self.horizon.hides((x, y, z), radius):
            return None
        depth = self.depth(x, y, z, R, 0.1)

        def passes(error):
            K = error * self.scale
            return K * self.corner > depth and (not self.frame.is_planar or K * (h + R) > depth * depth)
        return passes

    def passes(self, sphere, error_class):
        test = self.of(self.view_position(sphere), sphere[4])
        return test is not None and test(ERROR_M[error_class])

    def least(self, sphere):
        """The least class that passes; larger ones pass too."""
        test = self.of(self.view_position(sphere), sphere[4])
        return NONE if test is None else least(lambda c: test(ERROR_M[c]), NONE)

    def least_numbers(self, sphere):
        """The least error and the least radius that pass, to the last bit, at most 1e30."""
        position, most = self.view_position(sphere), f64_bits(1e30)
        test = self.of(position, sphere[4])
        error = most if test is None else least(lambda bits: test(bits_f64(bits)), most)
        radius = least(lambda bits: self.of(position, bits_f64(bits)) is not None, most)
        return bits_f64(error), bits_f64(radius)


class Horizon:
    """What a globe hides from a test's region: the end of section 9."""

    def __init__(self, test):
        frame, g = test.frame, test.frame.stretch
        self.g = g
        eye = test.eye[0], test.eye[1], test.eye[2] * g
        D = math.sqrt(dot(eye, eye))
        self.floor = frame.semi_major_m - g * (max(0.0, -frame.floor_m) + 1)
        q = self.floor - g * test.region_radius
        self.is_shadow = 0 < q < D * (1 - 1e-9)
        if self.is_shadow:
            self.sine = q / D
            self.cosine = math.sqrt((1 - self.sine) * (1 + self.sine))
            self.beyond = (D - q) * (1 + self.sine)
        self.D, self.a = D, tuple(v * (-1 / D) for v in eye)
        self.rows = [tuple(axis[i] * (g if i == 2 else 1.0) for axis in (test.right, test.up, test.forward)) for i in range(3)]
        top, b = frame.semi_major_m + g * (max(0.0, frame.highest_m) + 1), g * test.region_radius
        self.is_turned = self.is_shadow and D - b > self.floor * (1 + 1e-9) and top < 2 * self.floor
        if self.is_turned:
            u, v = self.floor / (D + b), self.floor / top
            self.limit = math.sqrt(2 - 2 * (u * v - math.sqrt((1 - u * u) * (1 - v * v)))) + b / (D - b)

    def hides(self, position, r):
        """A sphere about a position in view coordinates."""
        w = tuple(dot(position, row) for row in self.rows)
        if self.is_shadow:
            along = dot(w, self.a)
            beside = tuple(w[i] - along * self.a[i] for i in range(3))
            across = math.sqrt(dot(beside, beside))
            if min(along * self.sine - across * self.cosine, along - self.beyond) >= r * self.g:
                return True
        if not self.is_turned:
            return False
        c = tuple(w[i] - self.D * self.a[i] for i in range(3))
        shortened = 1 / math.sqrt(dot(c, c))
        t = tuple(c[i] * shortened + self.a[i] for i in range(3))
        return math.sqrt(dot(t, t)) >= self.limit + self.g / self.floor * r


def fingerprint(slot):
    h = ((slot + 1) * 0x9E3779B1 ^ (slot >> 32) * 0x27D4EB2F) & 0xFFFFFFFF
    h = (h ^ (h >> 15)) * 0x85EBCA77 & 0xFFFFFFFF
    h = (h ^ (h >> 13)) * 0xC2B2AE3D & 0xFFFFFFFF
    return h ^ (h >> 16)


class Page:
    """What is known of 256 slots."""

    def __init__(self, radius, finest=255, known=()):
        self.radius, self.finest, self.known, self.settled = radius, finest, set(known), {}  # settled: errors by slot

    def cost(self):
        return 128 + 512 * len({slot >> 6 for slot in self.known})


class Section:
    """Section 10: what a client holds, and its step."""

    def __init__(self, grid, frame, corner_heights, centre_heights, memory_bytes):
        self.grid, self.frame = grid, frame
        self.corners, self.centres = corner_heights, centre_heights
        self.memory_bytes = memory_bytes
        self.flat = flat_radii(grid, frame)
        self.slots = set()  # of the section
        self.heights = {}  # of known nodes, by slot
        self.bounds = {}  # of the frontier's nodes, by slot
        self.spheres = {}  # likewise
        self.pages = {}  # by slot >> 8
        self.memory = []  # of these, those without a node in the section or on its frontier, in their order
        self.nodes = {}  # of the section and its frontier, by slot
        self.model = Model()
        self.is_first = True
        self.fingerprint = 0

    def begin_from_nothing(self, keeps_pages):
        """With the empty section, on a connection that has sent a keyframe, or one that did not resume."""
        self.is_first, self.fingerprint = True, 0
        self.slots, self.bounds, self.spheres, self.nodes = set(), {}, {}, {}
        if not keeps_pages:
            self.model = Model()
            self.pages, self.memory, self.heights = {}, [], {}
        self.forget()

    def begin_anew(self, known, finest, memory_bytes):
        """The state in which a server resumes from what a client presents: known nodes, and the finest errors of their pages."""
        require(known <= set(self.heights), "what is presented is not known")
        self.model = Model()
        self.is_first = True
        self.memory_bytes = memory_bytes
        self.pages = {page: Page(self.pages[page].radius, finest[page]) for page in finest}
        for slot in known:
            self.pages[slot >> 8].known.add(slot)
        used = {slot >> 8 for slot in self.slots}
        self.memory = sorted((page for page in self.pages if page not in used), reverse=True)
        self.shrink()
        self.heights = {slot: h for slot, h in self.heights.items() if slot >> 8 in self.pages and slot in known}
        self.nodes = {slot: self.nodes[slot] for slot in self.slots}
        self.bounds, self.spheres = {}, {}
        for slot in self.slots:
            if self.is_leaf(slot):
                self.list(slot, 1)

    # ---- heights

    def height_of(self, x, y):
        if not self.grid.is_base(x, y):
            return self.heights[self.grid.slot(x, y)]
        k, roots = self.grid.k, self.grid.roots_x
        if x & ((1 << k) - 1):
            return self.centres[(y >> k) * roots + (x >> k)]
        return self.corners[(y >> k) * (roots + 1) + (x >> k)]

    def middle_of(self, n):
        (a, b), (c, d) = n.endpoints
        return (self.height_of(a, b) + self.height_of(c, d)) >> 1

    def displacement_of(self, x, y):
        if self.grid.is_base(x, y):
            return 0
        return self.height_of(x, y) - self.middle_of(self.grid.node(x, y))

    # ---- the frontier

    def sphere(self, slot):
        n, middle = self.nodes[slot], self.middle_of(self.nodes[slot])
        position = None if self.frame.is_planar else self.frame.position(n.x, n.y, middle)
        return n.x, n.y, middle, position, f32(self.flat[n.level] * RADIUS_FACTOR[self.pages[slot >> 8].radius])

    def list(self, slot, bound):
        self.bounds[slot] = bound
        if slot not in self.spheres:
            self.spheres[slot] = self.sphere(slot)

    def unlist(self, slot):
        if self.bounds.pop(slot, None) is not None:
            del self.spheres[slot]

    def has_parents(self, n):
        return all(p in self.slots for p in n.parents)

    def is_leaf(self, slot):
        return not any(self.grid.slot(*v) in self.slots for v in self.nodes[slot].children)

    # ---- the step

    def step(self, view, coder):
        """To the section of `view`; returns how many nodes were added and removed."""
        self.test = Test(self.frame, view)
        self.delta = DeltaDecoder(coder, self.model, self.grid, self.frame.height_quantum_m, self.height_of, self.displacement_of)
        levels = range(1, self.grid.last_level + 1)
        leaves, addable = {level: {} for level in levels}, {level: {} for level in levels}  # slot to: is it new?
        for slot, bound in self.bounds.items():
            is_leaf = slot in self.slots
            if self.test.passes(self.spheres[slot], bound) != is_leaf:
                (leaves if is_leaf else addable)[self.nodes[slot].level][slot] = False
        removed = sum(self.remove(level, leaves) for level in reversed(levels))
        for slots in addable.values():
            for slot in [s for s in slots if s not in self.bounds]:
                del slots[slot]
        arriving = {level: {} for level in range(1, self.grid.last_level + 2)}
        if self.is_first:
            self.seed(arriving)
        self.fresh = set()  # nodes that this step tells
        added = sum(self.add(level, addable[level], arriving) for level in levels)
        for slot in self.fresh:
            self.pages[slot >> 8].known.add(slot)
        self.forget()
        return added, removed

    def seed(self, arriving):
        """Adds all addable nodes to the frontier that are not on it."""
        self.is_first = False
        children = [self.grid.node(*v) for slot in self.slots for v in self.nodes[slot].children]
        for n in [*self.grid.first_level(), *children]:
            if n.slot not in self.slots and n.slot not in self.bounds and self.has_parents(n):
                arriving[n.level][n.slot] = n

    def resolve(self, slots):
        """(slot, is it in) of each, all decisions and heights read."""
        resolved, ordered = [], sorted(slots)
        for at in range(0, len(ordered), 256):
            resolved += self.resolve_group(ordered[at:at + 256], slots)
        return resolved

    def resolve_group(self, group, is_new):
        finest = {slot >> 8: self.pages[slot >> 8].finest for slot in group}
        self.delta.begin_group()
        self.decided = []  # (slot, least, bound before, was it in, is it in)
        known = {slot: self.resolve_one(slot, is_new[slot], finest[slot >> 8]) for slot in group}
        refused = self.refused([(slot, least, finest[slot >> 8]) for slot, (is_in, least) in known.items()
                                if is_in is None and is_new[slot] and slot not in self.slots])
        resolved = []
        for slot, (is_in, least) in known.items():
            if is_in is None:
                is_in = self.decide(slot, least, is_new[slot], finest[slot >> 8], slot in refused)
            resolved.append((slot, is_in))
        for slot, least, _, _, is_in in self.decided:
            if is_in and slot not in self.pages[slot >> 8].known:
                self.heights[slot] = self.delta.height(self.nodes[slot], least)
                self.fresh.add(slot)
        for slot, least, bound, was_in, is_in in self.decided:
            page = self.pages[slot >> 8]
            page.finest = min(page.finest, least)
            at_least = least if is_in else bound if was_in else finest[slot >> 8]
            at_most = least - 1 if not is_in else 255 if was_in else bound
            if at_least == at_most and (is_in or slot in page.known):
                page.settled[slot] = at_least
        return resolved

    def refused(self, new):
        """Those of the (slot, least, finest) that are refused with others of their page."""
        refused = set()
        for page, nodes in itertools.groupby(new, lambda node: node[0] >> 8):
            likely = [node for node in nodes if self.familiarity(*node) == 2]
            if likely and self.delta.are_refused(len(likely)):
                refused.update(slot for slot, _, _ in likely)
        return refused

    def resolve_one(self, slot, is_new, finest):
        """Whether it is in, None if that is to be decided; and its least error that passes."""
        least, is_leaf, page = self.test.least(self.spheres[slot]), slot in self.slots, self.pages[slot >> 8]
        is_settled = slot in page.settled
        if is_settled:
            self.bounds[slot] = page.settled[slot]
        elif is_leaf and self.bounds[slot] == 1:
            self.bounds[slot] = max(1, finest)
        bound = self.bounds[slot]
        if least == NONE:
            if is_leaf and not is_settled:
                self.bounds[slot] = 255
            return False, least
        if is_settled:
            return bound >= least, least
        if is_new and not is_leaf and slot in page.known and finest >= least:
            self.bounds[slot] = finest
            return True, least
        return (is_leaf if is_leaf == (bound >= least) else None), least

    def decide(self, slot, least, is_new, finest, is_refused):
        bound, is_leaf, n = self.bounds[slot], slot in self.slots, self.nodes[slot]
        if is_refused:
            decision = False
        elif is_leaf:
            decision = bool(self.delta.decision_of_leaf(n, is_new, bound, least))
        else:
            familiarity = self.familiarity(slot, least, finest) if is_new else None
            decision = bool(self.delta.decision_of_addable(n, bound, least, familiarity, finest))
        self.bounds[slot] = least if decision else least - 1
        self.decided.append((slot, least, bound, is_leaf, decision))
        return decision

    def familiarity(self, slot, least, finest):
        if slot in self.pages[slot >> 8].known:
            return 3
        if any(p not in self.pages[p >> 8].known for p in self.nodes[slot].parents):
            return 0
        return 1 if finest > least else 2

    def remove(self, level, leaves):
        removed = [slot for slot, stays in self.resolve(leaves[level]) if not stays]
        for slot in removed:
            self.slots.remove(slot)
            self.fingerprint = (self.fingerprint - fingerprint(slot)) & 0xFFFFFFFF
        for slot in removed:
            for child in self.nodes[slot].children:
                self.unlist(self.grid.slot(*child))
            for parent in self.nodes[slot].parents:
                if parent not in self.bounds and self.is_leaf(parent):
                    self.list(parent, 1)
                    leaves[level - 1][parent] = True
        return len(removed)

    def add(self, level, addable, arriving):
        absent = set()
        for slot, n in sorted(arriving[level].items()):
            if slot >> 8 in self.memory:
                self.memory.remove(slot >> 8)
            elif slot >> 8 in absent:
                continue
            elif slot >> 8 not in self.pages:
                if level > self.grid.last_whole_level and not self.delta.has_page():
                    absent.add(slot >> 8)
                    continue
                self.pages[slot >> 8] = Page(self.delta.radius())
            self.nodes[slot] = n
            self.list(slot, 255)
            addable[slot] = True
        added = [slot for slot, is_in in self.resolve(addable) if is_in]
        require(len(self.slots) + len(added) <= MOST_NODES, "a section of too many nodes")
        self.slots.update(added)
        for slot in added:
            self.fingerprint = (self.fingerprint + fingerprint(slot)) & 0xFFFFFFFF
            for parent in self.nodes[slot].parents:
                self.unlist(parent)
            for child in self.nodes[slot].children:
                n = self.grid.node(*child)
                if self.has_parents(n):
                    arriving[n.level][n.slot] = n
        return len(added)

    def tests(self):
        """What the last view's test makes of the section's nodes, as bytes: view-space position, radius, least class that passes; and of some
        nodes the least error and the least radius that pass."""
        for slot in sorted(self.slots):
            sphere = self.sphere(slot)
            yield struct.pack("<ddddfI", *self.test.view_position(sphere), sphere[4], self.test.least(sphere))
            if slot % 32 == 0:
                yield struct.pack("<dd", *self.test.least_numbers(sphere))

    def forget(self):
        used = {slot >> 8 for slots in (self.slots, self.bounds) for slot in slots}
        self.memory += sorted(page for page in self.pages if page not in used and page not in self.memory)
        self.shrink()
        for slot in [s for s in self.nodes if s not in self.slots and s not in self.bounds]:
            del self.nodes[slot]

    def shrink(self):
        cost = sum(self.pages[page].cost() for page in self.memory)
        while cost > self.memory_bytes:
            page = self.memory.pop(0)
            cost -= self.pages[page].cost()
            for slot in self.pages.pop(page).known:
                del self.heights[slot]
