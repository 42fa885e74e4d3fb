"""What both ends know of a terrain from the start: sections 6, 7 and 8 of docs/PROTOCOL.md."""

import math
import struct

from wire import require


def f32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def f32_above(x):
    """The least f32 that is not below a positive x."""
    nearest = f32(x)
    if nearest >= x:
        return nearest
    return struct.unpack("<f", struct.pack("<I", struct.unpack("<I", struct.pack("<f", nearest))[0] + 1))[0]


# ---- section 7: the frame

P, P_TAIL = 1.57079632679489655800, 6.12323399573676603587e-17


def sin_cos(a):
    turns = round(a / P)
    x, tail = a - turns * P, -turns * P_TAIL
    z = x * x
    v = z * x
    r = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * (
        2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))
    s = x - ((z * (0.5 * tail - v * r) - tail) - v * -1.66666666666666324348e-01)
    r = z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * (
        -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))))
    half = 0.5 * z
    w = 1 - half
    c = w + (((1 - w) - half) + (z * r - x * tail))
    return [(s, c), (c, -s), (-s, -c), (-c, s)][turns % 4]


FACES = [lambda u, v: (1.0, u, v), lambda u, v: (-u, 1.0, v), lambda u, v: (-u, -v, 1.0),
         lambda u, v: (-1.0, -v, -u), lambda u, v: (v, -1.0, -u), lambda u, v: (v, u, -1.0)]
F = 0.78539816339744830962


def tangent(s):
    s2 = s * s
    return s * (F + s2 * (0.1615 + s2 * ((1 - F) - 0.1615)))


class Frame:
    """Of a welcome's `frame`, over ground that is at most `highest` quanta high; geographic positions are cached row by row and column by
    column."""

    def __init__(self, fields, max_x, max_y, highest):
        self.__dict__.update(fields)
        numbers = [v for f in fields.values() for v in (f if isinstance(f, tuple) else (f,))]
        require(all(math.isfinite(v) and abs(v) <= 1e12 for v in numbers), "a frame beyond all numbers")
        require(self.height_quantum_m > 0 and self.kind in (0, 1, 2), "not a frame")
        self.is_planar, self.is_globe = self.kind == 0, self.kind == 2
        if self.is_planar:
            (ax, ay), (bx, by) = self.axis_x_m, self.axis_y_m
            require(ax * by - ay * bx > 0, "axes that are not right-handed")
            return
        if self.is_globe:
            self.face_steps, self.floor_m, self.highest_m = max_y, self.origin[2], highest * self.height_quantum_m
            require(1e3 <= self.semi_major_m <= 1e9 and 0 <= self.flattening <= 0.1, "not a body's ellipsoid")
            require(abs(self.floor_m) < 0.1 * self.semi_major_m, "no floor of a body")
            b = self.semi_major_m * (1 - self.flattening)
            self.a2, self.b2, self.stretch = self.semi_major_m * self.semi_major_m, b * b, self.semi_major_m / b
            return
        require(self.latitude_step_rad > 0 and self.longitude_step_rad > 0, "steps that are not positive")
        require(self.latitude0_rad >= -math.pi / 2 - 1e-9 and self.latitude0_rad + max_y * self.latitude_step_rad <= math.pi and
                abs(self.longitude0_rad) <= 4 * math.pi and
                self.longitude0_rad + max_x * self.longitude_step_rad <= 4 * math.pi, "outside the globe")
        require(self.semi_major_m > 0 and 0 <= self.flattening < 1, "not an ellipsoid")
        self.e2 = self.flattening * (2 - self.flattening)
        latitude, longitude, height = self.origin
        self.sin0, self.cos0 = sin_cos(latitude)
        self.rows, self.columns = {}, {}
        self.origin_ecef = self.ecef(self.row_at(latitude), self.column_at(longitude), height)

    def row_at(self, latitude):
        sin, cos = sin_cos(latitude)
        return sin, cos, self.semi_major_m / math.sqrt(1 - self.e2 * sin * sin)

    def column_at(self, longitude):
        return sin_cos(longitude - self.origin[1])

    def ecef(self, row, column, height):
        (sin_lat, cos_lat, normal), (sin_lon, cos_lon) = row, column
        ring = (normal + height) * cos_lat
        return ring * cos_lon, ring * sin_lon, (normal * (1 - self.e2) + height) * sin_lat

    def position(self, x, y, height):
        """Scene coordinates of a lattice vertex at `height` quanta."""
        metres = height * self.height_quantum_m
        if self.is_planar:
            dx, dy = x - self.anchor[0], y - self.anchor[1]
            (ax, ay), (bx, by) = self.axis_x_m, self.axis_y_m
            return dx * ax + dy * bx, dx * ay + dy * by, metres
        if self.is_globe:
            return self.position_on_globe(x, y, metres)
        if y not in self.rows:
            self.rows[y] = self.row_at(self.latitude0_rad + y * self.latitude_step_rad)
        if x not in self.columns:
            self.columns[x] = self.column_at(self.longitude0_rad + x * self.longitude_step_rad)
        p, o = self.ecef(self.rows[y], self.columns[x], metres), self.origin_ecef
        dx, dy, dz = p[0] - o[0], p[1] - o[1], p[2] - o[2]
        return dy, self.cos0 * dz - self.sin0 * dx, self.sin0 * dz + self.cos0 * dx

    def position_on_globe(self, x, y, metres):
        w = self.face_steps
        f = min(x // w, 5)
        cx, cy, cz = FACES[f](tangent((x - f * w) * (2 / w) - 1), tangent(y * (2 / w) - 1))
        g = 1 / math.sqrt((self.a2 * (cx * cx) + self.a2 * (cy * cy)) + self.b2 * (cz * cz))
        up = metres / math.sqrt((cx * cx + cy * cy) + cz * cz)
        around = self.a2 * g + up
        return cx * around, cy * around, cz * (self.b2 * g + up)


# ---- section 6: the grid

class Node:
    """A node's name and its relatives; slots where they are nodes, vertices (x, y) where they need not be."""

    __slots__ = ("x", "y", "slot", "level", "endpoints", "apexes", "parents", "children")


class Grid:
    """Of a welcome's `shape`; of a globe a cube's."""

    def __init__(self, shape, is_cube):
        self.k = k = shape["root_log2"]
        self.is_cube = is_cube
        require(1 <= k <= (24 if is_cube else 15), "root squares of no size")
        self.roots_x, self.roots_y = shape["roots_x"], shape["roots_y"]
        self.max_x, self.max_y = self.roots_x << k, self.roots_y << k
        if is_cube:
            require((self.roots_x, self.roots_y) == (6, 1), "not a cube")
            require((shape["samples_x"], shape["samples_y"]) == (self.max_x + 1, self.max_y + 1), "a cube with holes")
        else:
            require(self.roots_x >= 1 and self.roots_y >= 1 and max(self.max_x, self.max_y) <= 1 << 20, "no roots, or too many")
            require(self.max_x * self.max_y <= 1 << 37, "too many positions")
        require(2 <= shape["samples_x"] <= self.max_x + 1 and 2 <= shape["samples_y"] <= self.max_y + 1, "samples beyond the roots")
        self.last_level = 2 * k - 1
        require(shape["sparse_levels"] <= 2 * k - 2, "too many sparse levels")
        self.last_whole_level = self.last_level - shape["sparse_levels"]
        self.offset, self.tiles_x = [0, 0], [0]
        for level in range(1, self.last_level + 1):
            sides = level & 1 if not is_cube else 0
            tiles_x, tiles_y = (((roots << (level // 2)) + sides + 15) // 16 for roots in (self.roots_x, self.roots_y))
            self.tiles_x.append(tiles_x)
            self.offset.append(self.offset[-1] + 256 * tiles_x * tiles_y * (2 if level & 1 else 1))
        require(self.offset[self.last_whole_level + 1] < (1 << 32) - 1, "too many slots")
        self.nodes = {}  # by slot, as they are asked for

    def scale(self, x, y):
        both = x | y | 1 << self.k
        return (both & -both).bit_length() - 1

    def is_base(self, x, y):
        t = self.scale(x, y)
        return t == self.k or (t == self.k - 1 and (x >> t) & (y >> t) & 1)

    def slot(self, x, y):
        t = self.scale(x, y)
        is_centre = (x >> t) & (y >> t) & 1
        level = 2 * (self.k - 1 - t) + (0 if is_centre else 1)
        cx, cy = x >> (t + 1), y >> (t + 1)
        cell = 256 * ((cy >> 4) * self.tiles_x[level] + (cx >> 4)) + 16 * (cy & 15) + (cx & 15)
        return self.offset[level] + (cell if is_centre else 2 * cell + (0 if (x >> t) & 1 else 1))

    def around(self, x, y, offsets):
        """The names of the vertices that lie so from a node; those outside of the grid are left out."""
        if not self.is_cube:
            return [(x + dx, y + dy) for dx, dy in offsets if 0 <= x + dx <= self.max_x and 0 <= y + dy <= self.max_y]
        w = 1 << self.k
        return [self.name(*self.across(x // w, x % w, y, dx, dy)) for dx, dy in offsets]

    def across(self, f, x, y, dx, dy):
        """(square, x, y) of what lies so from (x, y) of square f, which has west and south sides alone."""
        w = 1 << self.k
        if x + dx < 0:
            g, x, y, dx, dy = (f - 1, w, y, dx, dy) if f & 1 else (f - 2, w - y, w, -dy, dx)
        elif y + dy < 0:
            g, x, y, dx, dy = (f - 2, w, w - x, dy, -dx) if f & 1 else (f - 1, x, w, dx, dy)
        else:
            g = f
        return g % 6, x + dx, y + dy

    def name(self, f, x, y):
        """Of a vertex of square f, its sides included."""
        w = 1 << self.k
        if x < w and y < w:
            return f * w + x, y
        if x == w and y == w:
            f, x, y = f + 2, 0, 0
        elif x == w:
            if f & 1 and y == 0:
                return 6 * w, 0
            f, x, y = (f + 2, w - y, 0) if f & 1 else (f + 1, 0, y)
        else:
            if not f & 1 and x == 0:
                return 0, w
            f, x, y = (f + 1, x, 0) if f & 1 else (f + 2, 0, w - x)
        return f % 6 * w + x, y

    def node(self, x, y):
        slot = self.slot(x, y)
        if slot not in self.nodes:
            self.nodes[slot] = self.make(x, y, slot)
        return self.nodes[slot]

    def make(self, x, y, slot):
        n = Node()
        t = self.scale(x, y)
        s, h = 1 << t, (1 << t) >> 1
        n.x, n.y, n.slot = x, y, slot
        along_x, along_y = [(-s, 0), (s, 0)], [(0, -s), (0, s)]
        if (x >> t) & (y >> t) & 1:
            n.level = 2 * (self.k - 1 - t)
            rising, falling = [(-s, -s), (s, s)], [(-s, s), (s, -s)]
            is_even = ((x >> (t + 1)) + (y >> (t + 1))) % 2 == 0
            endpoints, apexes = (rising, falling) if is_even else (falling, rising)
            children = along_x + along_y
        else:
            n.level = 2 * (self.k - 1 - t) + 1
            endpoints, apexes = (along_x, along_y) if (x >> t) & 1 else (along_y, along_x)
            children = [(-h, -h), (h, -h), (-h, h), (h, h)] if t > 0 else []
        n.endpoints, n.apexes, n.children = (self.around(x, y, offsets) for offsets in (endpoints, apexes, children))
        n.parents = [self.slot(*v) for v in n.apexes if not self.is_base(*v)]
        return n

    def first_level(self):
        """The nodes of level 1."""
        s, end = 1 << (self.k - 1), 0 if self.is_cube else 1  # a cube's far sides are others' near ones
        for y in range(0, self.max_y + end, s):
            for x in range(0, self.max_x + end, s):
                if (x ^ y) & s:
                    yield self.node(x, y)


# ---- section 8: bounds

ROOT2 = struct.unpack("<f", bytes.fromhex("3fb504f4")[::-1])[0]
FOURTHS = [1.0] + [struct.unpack("<f", bytes.fromhex(h)[::-1])[0] for h in ("3f9837f1", "3fb504f4", "3fd744fd")]
ERROR_M = [0.0] + [math.ldexp(ROOT2 if (c - 49) % 2 else 1.0, (c - 49) // 2) for c in range(1, 256)]
RADIUS_FACTOR = [math.ldexp(FOURTHS[c % 4], c // 4) for c in range(128)]


def flat_radii(grid, frame):
    """By level; nothing at 0."""
    def length(v):
        return math.sqrt(v[0] * v[0] + v[1] * v[1])
    if frame.is_planar:
        (ax, ay), (bx, by) = frame.axis_x_m, frame.axis_y_m
        along = max(length((ax, ay)), length((bx, by)))
        across = max(length((ax + bx, ay + by)), length((ax - bx, ay - by)))
    elif frame.is_globe:
        along = 1.61 * frame.semi_major_m / frame.face_steps
        across = along * math.sqrt(2)
    else:
        first = frame.latitude0_rad
        last = first + grid.max_y * frame.latitude_step_rad
        widest = 1.0 if (first < 0) != (last < 0) else max(sin_cos(first)[1], sin_cos(last)[1])
        v = (frame.semi_major_m * (abs(frame.longitude_step_rad) * widest), frame.semi_major_m * abs(frame.latitude_step_rad))
        along, across = max(v), length(v)
    flat = [0.0] * (grid.last_level + 1)
    radius = along + 2e-5
    for level in range(grid.last_level, 0, -1):
        s = float(1 << (grid.k - 1 - level // 2))
        if level < grid.last_level:
            radius = radius + (2e-5 + (0.5 * s * across if level & 1 else s * along))
        flat[level] = f32_above(radius)
    return flat
