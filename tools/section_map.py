"""A section seen from above, on a canvas: its triangles, some of its nodes, and the camera."""

import math

LINE = "#20303c"


class Map:
    """Scene metres to a panel of a canvas, north up."""

    def __init__(self, canvas, flight, panel, centre, metres):
        self.canvas, self.flight = canvas, flight
        self.x, self.y, self.width, self.height = panel
        self.scale = self.width / metres
        self.centre = centre

    def at(self, p):
        return (self.x + self.width / 2 + (p[0] - self.centre[0]) * self.scale,
                self.y + self.height / 2 - (p[1] - self.centre[1]) * self.scale)

    def vertex(self, v):
        return self.at(self.flight.position(*v))

    def shows(self, p):
        return self.x - 3 < p[0] < self.x + self.width + 3 and self.y - 3 < p[1] < self.y + self.height + 3

    def begin(self):
        self.canvas.rectangle(self.x, self.y, self.width, self.height, fill="#f4f6f7")
        self.canvas.clip(self.x, self.y, self.width, self.height)

    def end(self):
        self.canvas.unclip()
        self.canvas.rectangle(self.x, self.y, self.width, self.height, fill="none", stroke="#b8c2c9")

    def mesh(self, keyframe):
        """The triangles of a section, shaded by their slope."""
        by_shade = {}
        for corners, _ in self.flight.triangles(keyframe.heights):
            ps = [self.vertex(v) for v in corners]
            if self.meets(ps):
                by_shade.setdefault(self.shade(keyframe, corners), []).append(ps)
        for shade in sorted(by_shade):
            self.canvas.triangles(by_shade[shade], shade)

    def meets(self, ps):
        xs, ys = zip(*ps)
        return max(xs) > self.x and min(xs) < self.x + self.width and max(ys) > self.y and min(ys) < self.y + self.height

    def shade(self, keyframe, corners):
        a, b, c = (self.flight.position(*v, self.flight.height_in(keyframe, *v)) for v in corners)
        u, w = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        n = u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]
        light = abs(-0.45 * n[0] + 0.45 * n[1] + 0.77 * n[2]) / math.hypot(*n)
        level = 0.76 + 0.24 * round(10 * light) / 10
        return "#" + "".join(f"{round(255 * min(1.0, level * tint)):02x}" for tint in (0.95, 0.98, 0.95))

    def nodes(self, slots, radius, fill, rim=None):
        nodes = (self.flight.grid.nodes[slot] for slot in sorted(slots))
        self.canvas.dots([p for p in (self.vertex((n.x, n.y)) for n in nodes) if self.shows(p)], radius, fill, rim)

    def camera(self, keyframe, reach_m):
        """The eye and the sides of what it sees."""
        view = keyframe.view
        eye = self.at(view.pose.eye)
        ahead = rotated(view.pose.orientation, (0, 0, -1))
        half = math.atan(math.tan(view.fov / 2) * view.width / view.height)
        heading = math.atan2(ahead[1], ahead[0])
        for side in (-half, half):
            far = (view.pose.eye[0] + reach_m * math.cos(heading + side), view.pose.eye[1] + reach_m * math.sin(heading + side))
            self.canvas.line([eye, self.at(far)], stroke=LINE, stroke_width="1.6", stroke_dasharray="7 4")
        self.canvas.circle(*eye, 5, fill=LINE, stroke="#fff", stroke_width="1.5")


def rotated(q, v):
    w, u = q[0], q[1:]
    uv = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
    uuv = u[1] * uv[2] - u[2] * uv[1], u[2] * uv[0] - u[0] * uv[2], u[0] * uv[1] - u[1] * uv[0]
    return tuple(v[i] + 2 * (w * uv[i] + uuv[i]) for i in range(3))
