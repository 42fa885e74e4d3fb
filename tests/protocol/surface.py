"""Models: how the vertices of a surface are named and numbered: section 15 of
docs/PROTOCOL.md. A vertex is the number of a base vertex, or the name (patch, x, y) of a node."""

from epochs import CATMULL_ROM
from wire import require


class BaseMesh:
    def __init__(self, vertices, corners):
        require(0 < len(corners) <= 3 << 20 and len(corners) % 3 == 0 and vertices <= 1 << 20, "a base mesh of no size")
        self.vertices, self.corners = vertices, corners
        self.faces = len(corners) // 3
        require(all(v < vertices for v in corners) and len(set(corners)) == vertices, "vertices in no face, or of none")
        require(all(len(set(corners[i:i + 3])) == 3 for i in range(0, len(corners), 3)), "a vertex twice in a face")
        runs = {}
        for h in range(len(corners)):
            ends = corners[h], corners[self.next(h)]
            require(ends not in runs, "an edge that two faces run along in one way")
            runs[ends] = h
        self.twin = [runs.get((corners[self.next(h)], corners[h])) for h in range(len(corners))]
        self.is_closed = None not in self.twin
        self.check_fans()
        self.first = [h for h in range(len(corners)) if self.twin[h] is None or self.twin[h] > h]
        self.edge = [0] * len(corners)
        for number, h in enumerate(self.first):
            self.edge[h] = number
            if self.twin[h] is not None:
                self.edge[self.twin[h]] = number

    @staticmethod
    def next(h):
        return h - 2 if h % 3 == 2 else h + 1

    @staticmethod
    def previous(h):
        return h + 2 if h % 3 == 0 else h - 1

    def check_fans(self):
        faces_at, start = {}, {}
        for h, v in enumerate(self.corners):
            faces_at[v] = faces_at.get(v, 0) + 1
            if v not in start or self.twin[h] is None:
                start[v] = h
        for v, begin in start.items():
            h, met = begin, 0
            while h is not None and (met == 0 or h != begin):
                met, h = met + 1, self.twin[self.previous(h)]
            require(met == faces_at[v], "faces that hang together in a point only")


def scale_log2(x, y):
    both = x | y
    return (both & -both).bit_length() - 1


class Quadrisection:
    def __init__(self, mesh, k):
        self.mesh, self.k, self.size = mesh, k, 1 << k
        self.last_level = k
        self.base_vertices = mesh.vertices

    def slots_of(self, level):
        m = 1 << (level - 1)
        return self.mesh.faces * 3 * (m * (m + 1) // 2)

    def on_half_edge(self, h, r):
        return (h // 3, *[(r, 0), (self.size - r, r), (0, self.size - r)][h % 3])

    def half_edge_of(self, f, x, y):
        """The half-edge that the point is on, and where; None inside."""
        if y == 0 and x < self.size:
            return 3 * f, x
        if x + y == self.size and x > 0:
            return 3 * f + 1, y
        return (3 * f + 2, self.size - y) if x == 0 else None

    def positions(self, f, x, y):
        """Of a point that is no corner: on its own face, and on the neighbour."""
        positions, on = [(f, x, y)], self.half_edge_of(f, x, y)
        if on and self.mesh.twin[on[0]] is not None:
            positions.append(self.on_half_edge(self.mesh.twin[on[0]], self.size - on[1]))
        return positions

    def is_inside(self, x, y):
        return x >= 0 and y >= 0 and x + y <= self.size

    def name(self, f, x, y):
        corners = {(0, 0): 0, (self.size, 0): 1, (0, self.size): 2}
        if (x, y) in corners:
            return self.mesh.corners[3 * f + corners[x, y]]
        return min(self.positions(f, x, y))

    def level(self, n):
        return self.k - scale_log2(n[1], n[2])

    def endpoints(self, n):
        f, x, y = n
        t = scale_log2(x, y)
        s = 1 << t
        odd_x, odd_y = x >> t & 1, y >> t & 1
        dx, dy = (s if odd_x else 0), (-s if odd_x and odd_y else s if odd_y else 0)
        return [self.name(f, x - dx, y - dy), self.name(f, x + dx, y + dy)]

    def parents(self, n):
        return [e for e in self.endpoints(n) if isinstance(e, tuple) and self.level(e) == self.level(n) - 1]

    def children(self, n):
        t = scale_log2(n[1], n[2])
        if t == 0:
            return []
        h, names = 1 << (t - 1), set()
        for f, x, y in self.positions(*n):
            for dx, dy in ((h, 0), (-h, 0), (0, h), (0, -h), (h, -h), (-h, h)):
                if self.is_inside(x + dx, y + dy):
                    names.add(self.name(f, x + dx, y + dy))
        return sorted(names)

    def slot_in_level(self, n):
        f, x, y = n
        t = scale_log2(x, y)
        m = 1 << (self.level(n) - 1)
        column, row = x >> (t + 1), y >> (t + 1)
        cell = row * (m + 1) + column if row < (m + 1) >> 1 else (m - 1 - row) * (m + 1) + row + 1 + column
        odd_x, odd_y = x >> t & 1, y >> t & 1
        return 3 * f * (m * (m + 1) // 2) + 3 * cell + (2 if odd_x and odd_y else 1 if odd_y else 0)

    def first_level(self):
        s = self.size >> 1
        return sorted({self.name(f, x, y) for f in range(self.mesh.faces) for x, y in ((s, 0), (0, s), (s, s))})


def morton(u, v):
    return sum((u >> i & 1) << 2 * i | (v >> i & 1) << (2 * i + 1) for i in range(16))


class Bisection:
    def __init__(self, mesh, k):
        self.mesh, self.k, self.size = mesh, k, 1 << k
        self.last_level = 2 * k
        self.base_vertices = mesh.vertices + mesh.faces

    def slots_of(self, level):
        c = (level - 1) // 2
        return (len(self.mesh.first) << 2 * c) * (1 if level & 1 else 2)

    def is_inside(self, e, x, y):
        if not (0 <= x <= self.size and 0 <= y <= self.size):
            return False
        return x <= y or self.mesh.twin[self.mesh.first[e]] is not None

    def name(self, e, x, y):
        if 0 < y < self.size:
            return e, x, y
        first = self.mesh.first[e]
        h, r = (self.mesh.twin[first], x) if y == 0 else (first, self.size - x)
        if r == 0:
            return self.mesh.corners[first if y == 0 else self.mesh.next(first)]
        if r == self.size:
            return self.mesh.vertices + h // 3
        after = self.mesh.next(h)
        edge = self.mesh.edge[after]
        return (edge, 0, r) if self.mesh.first[edge] == after else (edge, self.size, self.size - r)

    def positions(self, e, x, y):
        """On its own square, and on a second one."""
        positions = [(e, x, y)]
        if x in (0, self.size):
            first = self.mesh.first[e]
            b, r = (self.mesh.previous(first), y) if x == 0 else (self.mesh.previous(self.mesh.twin[first]), self.size - y)
            edge = self.mesh.edge[b]
            positions.append((edge, self.size - r, self.size) if self.mesh.first[edge] == b else (edge, r, 0))
        return positions

    @staticmethod
    def is_centre(x, y, t):
        return x >> t & y >> t & 1

    def level(self, n):
        t = scale_log2(n[1], n[2])
        return 2 * (self.k - 1 - t) + (1 if self.is_centre(n[1], n[2], t) else 2)

    def along(self, x, y, t):
        """From a node to an end of its edge, and to where its triangles' other corners are."""
        s = 1 << t
        if not self.is_centre(x, y, t):
            return ((0, s), (s, 0)) if y >> t & 1 else ((s, 0), (0, s))
        rises = ((x >> (t + 1)) + (y >> (t + 1))) % 2 == 0
        return ((s, s), (s, -s)) if rises else ((s, -s), (s, s))

    def inside(self, e, points):
        return [self.name(e, x, y) for x, y in points if self.is_inside(e, x, y)]

    def endpoints(self, n):
        e, x, y = n
        dx, dy = self.along(x, y, scale_log2(x, y))[0]
        return [self.name(e, x - dx, y - dy), self.name(e, x + dx, y + dy)]

    def parents(self, n):
        t = scale_log2(n[1], n[2])
        if self.is_centre(n[1], n[2], t) and t == self.k - 1:
            return []
        names = set()
        for e, x, y in [n] if self.is_centre(n[1], n[2], t) else self.positions(*n):
            dx, dy = self.along(x, y, t)[1]
            names.update(self.inside(e, [(x - dx, y - dy), (x + dx, y + dy)]))
        return sorted(names)

    def children(self, n):
        e, x, y = n
        t = scale_log2(x, y)
        s, h = 1 << t, 1 << t >> 1
        if self.is_centre(x, y, t):
            return self.inside(e, [(x - s, y), (x + s, y), (x, y - s), (x, y + s)])
        names = set()
        for e, x, y in self.positions(*n) if t > 0 else []:
            names.update(self.inside(e, [(x + dx, y + dy) for dx in (-h, h) for dy in (-h, h)]))
        return sorted(names)

    def slot_in_level(self, n):
        e, x, y = n
        t = scale_log2(x, y)
        cells = e << 2 * (self.k - 1 - t)
        if self.is_centre(x, y, t):
            return cells + morton(x >> (t + 1), y >> (t + 1))
        if x == self.size:
            return 2 * (cells + morton(y >> (t + 1), 0)) + 1
        return 2 * (cells + morton(x >> (t + 1), y >> (t + 1))) + (0 if y >> t & 1 else 1)

    def first_level(self):
        return [(e, self.size >> 1, self.size >> 1) for e in range(len(self.mesh.first))]


class Node:
    """Endpoints are vertices; parents and children are nodes' slots."""

    __slots__ = ("name", "slot", "level", "endpoints", "parents", "children")


class Surface:
    """Of a welcome's model: what is known before any node."""

    def __init__(self, model, epochs, blend):
        k = model["halvings"]
        require(model["rule"] in (0, 1) and 1 <= k <= 15, "a rule that is unknown, or no halvings")
        require(0 < model["quantum_m"] <= 1e6 and model["atlas_side"] <= 1 << 14, "a step or an image of no size")
        self.mesh = BaseMesh(model["vertices"], model["faces"] or [])
        self.rule = (Bisection if model["rule"] else Quadrisection)(self.mesh, k)
        numbers = model["base"] or []
        require(len(numbers) == 3 * self.rule.base_vertices and all(abs(v) <= 1 << 28 for v in numbers),
                "base vertices that do not fit")
        self.base = [tuple(numbers[i:i + 3]) for i in range(0, len(numbers), 3)]
        poses, moves = model["pose_epochs"] or [], model["base_moves"] or []
        self.moves = max(len(poses) - 1, 0)
        require(not poses or 2 <= len(poses) <= 64 and poses == sorted(set(poses)) and poses[-1] < epochs and blend != CATMULL_ROM,
                "poses of no epochs, or of a scene that overshoots")
        require(len(moves) == self.moves * len(numbers), "moves that do not fit")
        each = [tuple(moves[i:i + 3]) for i in range(0, len(moves), 3)]
        self.base_moves = [each[v * self.moves:(v + 1) * self.moves] for v in range(len(self.base))]
        require(all(abs(p + m) <= 1 << 28 for v, of in zip(self.base, self.base_moves) for move in of for p, m in zip(v, move)),
                "base vertices that move too far")
        self.quantum_m, self.is_closed, self.last_level = model["quantum_m"], self.mesh.is_closed, self.rule.last_level
        self.offset = [0, 0]
        for level in range(1, self.last_level + 1):
            self.offset.append(self.offset[-1] + (self.rule.slots_of(level) + 255) // 256 * 256)
        require(self.offset[-1] <= 1 << 26, "too many slots")
        self.nodes, self.first_level = {}, []
        self.first_level = [self.make(n) for n in self.rule.first_level()]

    def slot(self, name):
        return self.offset[self.rule.level(name)] + self.rule.slot_in_level(name)

    def make(self, name):
        """The slot of a node, which can be looked up from now on."""
        slot = self.slot(name)
        if slot not in self.nodes:
            n = self.nodes[slot] = Node()
            n.name, n.slot, n.level = name, slot, self.rule.level(name)
            n.endpoints = self.rule.endpoints(name)
            n.parents = [self.slot(p) for p in self.rule.parents(name)]
            n.children = None
        return slot

    def children(self, slot):
        n = self.nodes[slot]
        if n.children is None:
            n.children = [self.make(c) for c in self.rule.children(n.name)]
        return n.children
