"""The refinement test and the step from keyframe to keyframe: sections 9 and 10 of docs/PROTOCOL.md."""

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


def fingerprint(slot):
    h = slot * 0x9E3779B1 & 0xFFFFFFFF
    h = (h ^ (h >> 15)) * 0x85EBCA77 & 0xFFFFFFFF
    h = (h ^ (h >> 13)) * 0xC2B2AE3D & 0xFFFFFFFF
    return h ^ (h >> 16)


class Section:
    """Section 10: what a client holds, and its step."""

    def __init__(self, grid, frame, corner_heights, centre_heights):
        self.grid, self.frame = grid, frame
        self.corners, self.centres = corner_heights, centre_heights
        self.flat = flat_radii(grid, frame)
        self.heights = {}  # of the section's nodes, by slot
        self.bounds = {}  # of the frontier's nodes, by slot
        self.spheres = {}  # likewise
        self.pages = {}  # quantised radii, by page
        self.nodes = {}  # of the section and its frontier, by slot
        self.model = Model()
        self.is_first = True
        self.fingerprint = 0

    def begin_anew(self):
        """The state in which a server resumes from a client's section: nothing is known but the nodes and their pages' radii."""
        self.model = Model()
        self.is_first = True
        self.pages = {slot >> 8: self.pages[slot >> 8] for slot in self.heights}
        self.nodes = {slot: self.nodes[slot] for slot in self.heights}
        self.bounds, self.spheres = {}, {}
        for slot in self.heights:
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
        return n.x, n.y, middle, position, f32(self.flat[n.level] * RADIUS_FACTOR[self.pages[slot >> 8]])

    def list(self, slot, bound):
        self.bounds[slot] = bound
        if slot not in self.spheres:
            self.spheres[slot] = self.sphere(slot)

    def unlist(self, slot):
        if self.bounds.pop(slot, None) is not None:
            del self.spheres[slot]

    def has_parents(self, n):
        return all(p in self.heights for p in n.parents)

    def is_leaf(self, slot):
        return not any(self.grid.slot(*v) in self.heights for v in self.nodes[slot].children)

    # ---- the step

    def step(self, view, coder):
        """To the section of `view`; returns how many nodes were added and removed."""
        self.test = Test(self.frame, view)
        self.delta = DeltaDecoder(coder, self.model, self.grid, self.frame.height_quantum_m, self.height_of, self.displacement_of)
        levels = range(1, self.grid.last_level + 1)
        leaves, addable = {level: {} for level in levels}, {level: {} for level in levels}  # slot to: is it new?
        for slot, bound in self.bounds.items():
            is_leaf = slot in self.heights
            if self.test.passes(self.spheres[slot], bound) != is_leaf:
                (leaves if is_leaf else addable)[self.nodes[slot].level][slot] = False
        removed = sum(self.remove(level, leaves) for level in reversed(levels))
        for slots in addable.values():
            for slot in [s for s in slots if s not in self.bounds]:
                del slots[slot]
        arriving = {level: {} for level in range(1, self.grid.last_level + 2)}
        if self.is_first:
            self.seed(arriving)
        added = sum(self.add(level, addable[level], arriving) for level in levels)
        self.forget()
        return added, removed

    def seed(self, arriving):
        """Adds all addable nodes to the frontier that are not on it."""
        self.is_first = False
        children = [self.grid.node(*v) for slot in self.heights for v in self.nodes[slot].children]
        for n in [*self.grid.first_level(), *children]:
            if n.slot not in self.heights and n.slot not in self.bounds and self.has_parents(n):
                arriving[n.level][n.slot] = n

    def resolve(self, slots):
        """(slot, is it in, least class) of each, all decisions read."""
        resolved, ordered = [], sorted(slots)
        for at, slot in enumerate(ordered):
            if at % 256 == 0:
                self.delta.begin_group()
            resolved.append((slot, *self.resolve_one(slot, slots[slot])))
        return resolved

    def resolve_one(self, slot, is_new):
        least, bound, is_leaf = self.test.least(self.spheres[slot]), self.bounds[slot], slot in self.heights
        if least == NONE:
            if is_leaf:
                self.bounds[slot] = 255
            return False, least
        if is_leaf == (bound >= least):
            return is_leaf, least
        ask = self.delta.decision_of_leaf if is_leaf else self.delta.decision_of_addable
        decision = bool(ask(self.nodes[slot], is_new, bound, least))
        self.bounds[slot] = least if decision else least - 1
        return decision, least

    def remove(self, level, leaves):
        removed = [slot for slot, stays, _ in self.resolve(leaves[level]) if not stays]
        for slot in removed:
            del self.heights[slot]
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
        for slot, n in sorted(arriving[level].items()):
            if slot >> 8 not in self.pages:
                self.pages[slot >> 8] = self.delta.radius()
            self.nodes[slot] = n
            self.list(slot, 255)
            addable[slot] = True
        passed = [(slot, least) for slot, is_in, least in self.resolve(addable) if is_in]
        heights = {slot: self.delta.height(self.nodes[slot], least) for slot, least in passed}
        require(len(self.heights) + len(heights) <= MOST_NODES, "a section of too many nodes")
        self.heights.update(heights)
        for slot in heights:
            self.fingerprint = (self.fingerprint + fingerprint(slot)) & 0xFFFFFFFF
            for parent in self.nodes[slot].parents:
                self.unlist(parent)
            for child in self.nodes[slot].children:
                n = self.grid.node(*child)
                if self.has_parents(n):
                    arriving[n.level][n.slot] = n
        return len(heights)

    def tests(self):
        """What the last view's test makes of the section's nodes, as bytes: view-space position, radius, least class that passes; and of some
        nodes the least error and the least radius that pass."""
        for slot in sorted(self.heights):
            sphere = self.sphere(slot)
            yield struct.pack("<ddddfI", *self.test.view_position(sphere), sphere[4], self.test.least(sphere))
            if slot % 32 == 0:
                yield struct.pack("<dd", *self.test.least_numbers(sphere))

    def forget(self):
        used = {slot >> 8 for slots in (self.heights, self.bounds) for slot in slots}
        for page in [p for p in self.pages if p not in used]:
            del self.pages[page]
        for slot in [s for s in self.nodes if s not in self.heights and s not in self.bounds]:
            del self.nodes[slot]
