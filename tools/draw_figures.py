#!/usr/bin/env python3
"""Draws the figures of docs/ENGINE.md from a recorded session of this repository's server (tests/protocol/golden).

    tools/draw_figures.py            writes docs/images/engine_*.svg
    tools/draw_figures.py --check    exits 1 if a committed figure is not what would be drawn
"""

import math
import os
import sys

import source_files
from replayed_flight import Flight
from section_map import LINE, Map
from slack_of_tests import Camera, tests_per_step
from svg import Canvas

IMAGES = os.path.join(source_files.ROOT, "docs", "images")
IN_SECTION, ADDABLE, SKY = "#d9591c", "#2f6fb0", "#2f6fb0"
ADDED, REMOVED = "#11865a", "#c2183c"


def legend(canvas, x, y, entries):
    """Dots with words, in a row."""
    for words, width, style in entries:
        canvas.circle(x, y - 4, 4.5, **style)
        canvas.text(x + 11, y, words)
        x += width


def keyframe_of(flight, index):
    return next(k for k in flight.keyframes if k.index == index)


def removable(k):
    return [s for s in k.bounds if s in k.heights]


def addable(k):
    return [s for s in k.bounds if s not in k.heights]


# ---- the figures

def draw_section(flight):
    """One section with its frontier."""
    k = keyframe_of(flight, 8)
    canvas = Canvas(900, 560)
    m = Map(canvas, flight, (10, 10, 880, 500), (30, -40), 950)
    m.begin()
    m.mesh(k)
    m.nodes(addable(k), 2.0, "#fff", ADDABLE)
    m.nodes(removable(k), 3.0, IN_SECTION)
    m.camera(k, 2500)
    m.end()
    legend(canvas, 24, 538, [
        (f"removable: in the section, without children there ({len(removable(k))})", 430, {"fill": IN_SECTION}),
        (f"addable: outside it, with all parents inside ({len(addable(k))})", 380,
         {"fill": "#fff", "stroke": ADDABLE, "stroke-width": "1.6"})])
    return canvas


def draw_step(flight):
    """Two keyframes: what the step takes out and puts in."""
    a, b = keyframe_of(flight, 18), keyframe_of(flight, 19)
    canvas = Canvas(900, 500)
    for k, x, slots, colour, words in ((a, 10, set(a.heights) - set(b.heights), REMOVED, "removed by the step"),
                                       (b, 455, set(b.heights) - set(a.heights), ADDED, "added by the step")):
        m = Map(canvas, flight, (x, 36, 435, 420), (-120, 50), 880)
        m.begin()
        m.mesh(k)
        m.nodes(slots, 3.2, colour, "#fff")
        m.camera(k, 2500)
        m.end()
        canvas.text(x, 24, f"keyframe {k.index}: {len(k.heights)} nodes", 15)
        legend(canvas, x + 8, 480, [(f"{words}: {len(slots)}", 300, {"fill": colour})])
    return canvas


def blend_row(flight, k, y, xs):
    return [surface_height(flight, k, x, y) * flight.section.frame.height_quantum_m for x in xs]


def surface_height(flight, k, x, y):
    """Of a section's mesh, in quanta, at any place of the lattice plane."""
    side = 1 << flight.grid.k
    x0, y0 = int(x // side) * side, int(y // side) * side
    ring = [(x0, y0), (x0 + side, y0), (x0 + side, y0 + side), (x0, y0 + side)]
    for i in range(4):
        corners = [ring[i], ring[(i + 1) % 4], (x0 + side // 2, y0 + side // 2)]
        if min(weights_in(corners, x, y)) >= -1e-9:
            break
    level = 0
    while level < flight.grid.last_level:
        a, b, apex = corners
        middle = (a[0] + b[0]) // 2, (a[1] + b[1]) // 2
        if flight.grid.slot(*middle) not in k.heights:
            break
        corners = [apex, a, middle]
        if min(weights_in(corners, x, y)) < -1e-9:
            corners = [b, apex, middle]
        level += 1
    return sum(w * flight.height_in(k, *v) for w, v in zip(weights_in(corners, x, y), corners))


def weights_in(corners, x, y):
    (ax, ay), (bx, by), (cx, cy) = corners
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
    v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
    return u, v, 1 - u - v


def draw_blend(flight):
    """A cut through two sections and what is drawn between them, heights relative to a straight line."""
    a, b = keyframe_of(flight, 45), keyframe_of(flight, 46)
    first, last, y = 134.0, 160.0, 54
    canvas = Canvas(900, 430)
    xs = [first + i / 8 for i in range(int(8 * (last - first)) + 1)]
    rows = [blend_row(flight, k, y, xs) for k in (a, b)]
    slope = (rows[1][-1] - rows[1][0]) / (last - first)
    rows = [[h - slope * (x - first) for x, h in zip(xs, row)] for row in rows]
    low, high = min(map(min, rows)), max(map(max, rows))
    left, right, top, bottom = 20, 880, 60, 335

    def at(x, metres):
        return left + (x - first) / (last - first) * (right - left), bottom - (metres - low) / (high - low) * (bottom - top)
    for weight in (0.25, 0.5, 0.75):
        mixed = [p + (q - p) * weight for p, q in zip(*rows)]
        canvas.line([at(x, h) for x, h in zip(xs, mixed)], stroke="#b9a3d8", stroke_width="1.3")
    for row, colour in zip(rows, (IN_SECTION, SKY)):
        canvas.line([at(x, h) for x, h in zip(xs, row)], stroke=colour, stroke_width="2.4")
    for x in range(math.ceil(first), math.floor(last) + 1):
        draw_node(canvas, flight, (a, b), (x, y), [at(x, row[int(8 * (x - first))]) for row in rows])
    canvas.text(20, 26, f"A cut along one lattice row: keyframe {a.index}, keyframe {b.index}, and frames between them", 15)
    for x, colour, words in ((24, IN_SECTION, f"keyframe {a.index}, weight 0"), (224, SKY, f"keyframe {b.index}, weight 1"),
                             (424, "#b9a3d8", "frames at 1/4, 1/2, 3/4")):
        canvas.line([(x, 372), (x + 28, 372)], stroke=colour, stroke_width="3")
        canvas.text(x + 36, 377, words)
    legend(canvas, 28, 410, [("node of both sections, or base vertex", 300, {"fill": LINE}),
                             ("added: leaves the middle of its edge", 290, {"fill": ADDED}),
                             ("removed: returns there", 200, {"fill": REMOVED})])
    return canvas


def draw_node(canvas, flight, keyframes, vertex, ends):
    """A vertex of the cut at both ends of the blend, if it is one."""
    is_base = flight.grid.is_base(*vertex)
    held = [is_base or flight.grid.slot(*vertex) in k.heights for k in keyframes]
    if all(held):
        canvas.circle(*ends[1], 3.4, fill=LINE)
    elif any(held):
        colour = ADDED if held[1] else REMOVED
        canvas.line(ends, stroke=colour, stroke_width="1.6")
        canvas.circle(*ends[1 if held[1] else 0], 4.2, fill=colour)


def draw_slack(flight):
    """How long each test result holds, and how many frontier entries each step tests."""
    canvas = Canvas(900, 520)
    k, after = keyframe_of(flight, 8), keyframe_of(flight, 9)
    camera = Camera(flight.section.frame, k.view)
    pace = camera.bound_to(after.view)
    lasts = {slot: camera.longest(k.spheres[slot], bound, pace)[3] for slot, bound in k.bounds.items()}
    bands = ((0, 1, "#c2183c", "less than one", 122), (1, 4, "#f0a030", "1 to 4", 82), (4, 16, "#4f9d77", "4 to 16", 88),
             (16, math.inf, "#9db4c4", "more", 80))
    m = Map(canvas, flight, (10, 36, 500, 430), (-130, -40), 700)
    m.begin()
    m.mesh(k)
    for low, high, colour, _, _ in reversed(bands):
        m.nodes([s for s in k.bounds if low <= lasts[s] < high], 2.9, colour, "#fff")
    m.camera(k, 2500)
    m.end()
    canvas.text(10, 24, "For how many steps each test result is sure to hold", 15)
    legend(canvas, 24, 492, [(words, width, {"fill": colour}) for _, _, colour, words, width in bands])
    draw_step_bars(canvas, flight)
    return canvas


def draw_step_bars(canvas, flight):
    pairs = [(a, b) for a, b in zip(flight.keyframes, flight.keyframes[1:]) if 3 <= b.index <= 14]
    tested = tests_per_step(flight)
    colours = "#dde5ea", "#f0a030", LINE
    most = max(len(b.bounds) for _, b in pairs)
    left, bottom, height, width = 540, 440, 350, 350
    step = width / len(pairs)
    for i, (a, b) in enumerate(pairs):
        x = left + i * step
        for count, colour in zip((len(b.bounds), tested[b.index], len(set(a.heights) ^ set(b.heights))), colours):
            canvas.rectangle(x + 2, bottom - height * count / most, step - 4, height * count / most, fill=colour)
        canvas.text(x + step / 2, bottom + 16, str(b.index), 11, "middle")
    canvas.text(left, 24, "Frontier entries of keyframes 3 to 14", 15)
    for x, colour, words in zip((544, 606, 690), colours, ("all", "tested", "added or removed")):
        canvas.rectangle(x, 482, 12, 12, fill=colour)
        canvas.text(x + 18, 493, words)


def draw_delta(flight):
    """What one step reads, call by call."""
    k = keyframe_of(flight, 16)
    canvas = Canvas(900, 440)
    calls = [c for c in k.calls if c.count]
    colours = {"decision": "#f0a030", "height": SKY, "radius": ADDED}
    total = sum(c.bits for c in calls)
    left, right, top, row = 118, 880, 62, 21
    levels = sorted({c.level for c in calls})
    at = {level: top + row * i for i, level in enumerate(levels)}
    for level, y in at.items():
        canvas.text(left - 12, y + 14, f"level {level}", 12, "end")
        canvas.line([(left, y + row - 1), (right, y + row - 1)], stroke="#e4e9ec", stroke_width="1")
    x = left
    for c in calls:
        width = (right - left) * c.bits / total
        canvas.rectangle(x, at[c.level] + 2, max(width, 1), row - 5, fill=colours[c.kind], opacity="1")
        x += width
    end = top + row * len(levels)
    canvas.line([(left, end + 12), (right, end + 12)], stroke=LINE, stroke_width="1.2")
    canvas.polygon([(right, end + 12), (right - 9, end + 8), (right - 9, end + 16)], fill=LINE)
    canvas.text((left + right) / 2, end + 30, f"bits in the order in which the step reads them: {total:.0f}", 13, "middle")
    canvas.text(10, 24, f"The delta of keyframe {k.index}: {sum(c.count for c in calls if c.kind == 'height')} nodes added", 15)
    x = left
    for kind, plural in (("decision", "decisions"), ("height", "heights"), ("radius", "radii of pages")):
        count, bits = (sum(getattr(c, f) for c in calls if c.kind == kind) for f in ("count", "bits"))
        canvas.rectangle(x, end + 48, 12, 12, fill=colours[kind])
        canvas.text(x + 18, end + 59, f"{count} {plural}, {bits:.0f} bits")
        x += 250
    canvas.height = int(end + 80)
    return canvas


def draw_region(flight):
    """Poses that were flown, and the regions of three keyframes."""
    canvas = Canvas(900, 380)
    indices = (14, 15, 16, 17)
    frames = [keyframe_of(flight, i) for i in indices]
    eyes = [k.view.pose.eye for k in frames]
    centre = [(min(e[i] for e in eyes) + max(e[i] for e in eyes)) / 2 for i in (0, 1)]
    radius = max(k.view.region_radius for k in frames)
    across = max(e[1] for e in eyes) - min(e[1] for e in eyes) + 2.3 * radius
    m = Map(canvas, flight, (10, 36, 420, 330), centre, across * 420 / 330)
    tints = ("#d9591c", "#2f6fb0", "#11865a", "#8b5fbf")
    m.begin()
    for k, tint in zip(frames, tints):
        canvas.circle(*m.at(k.view.pose.eye), k.view.region_radius * m.scale, fill=tint, fill_opacity="0.13", stroke=tint, stroke_width="1.6")
    shown = [(t, p) for t, p in flight.poses if frames[0].time_s - 0.35 <= t <= frames[-1].time_s + 0.35]
    canvas.line([m.at(p.eye) for _, p in shown], stroke=LINE, stroke_width="1.4")
    for _, p in shown:
        canvas.circle(*m.at(p.eye), 2.6, fill=LINE)
    for k, tint in zip(frames, tints):
        canvas.circle(*m.at(k.view.pose.eye), 5.5, fill=tint, stroke="#fff", stroke_width="1.4")
    m.end()
    canvas.text(10, 24, "Four keyframes, their regions, and the poses flown", 15)
    draw_intervals(canvas, frames, tints)
    return canvas


def draw_intervals(canvas, frames, tints):
    interval = frames[1].time_s - frames[0].time_s
    left, width = 540, 335 / (len(frames) + 1)
    canvas.text(450, 24, "For how long each one is shown", 15)
    for i, (k, tint) in enumerate(zip(frames, tints)):
        y = 70 + 60 * i
        canvas.text(left - 12, y + 21, f"keyframe {k.index}", 12, "end")
        canvas.rectangle(left + i * width, y, 2 * width, 34, fill=tint, fill_opacity="0.2", stroke=tint)
        canvas.line([(left + (i + 1) * width, y - 4), (left + (i + 1) * width, y + 38)], stroke=tint, stroke_width="3")
    for i in range(len(frames) + 2):
        canvas.text(left + i * width, 330, f"{(i - 1) * interval:+.1f} s", 11, "middle")
        canvas.line([(left + i * width, 60), (left + i * width, 312)], stroke="#c9d2d8", stroke_width="0.8", stroke_dasharray="3 3")


FIGURES = {"section": draw_section, "step": draw_step, "slack": draw_slack, "delta": draw_delta, "blend": draw_blend,
           "region": draw_region}


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    flight, stale = Flight("planar"), 0
    for name, draw in FIGURES.items():
        path = os.path.join(IMAGES, f"engine_{name}.svg")
        drawn = draw(flight).document()
        if not sys.argv[1:]:
            with open(path, "w", encoding="utf-8") as file:
                file.write(drawn)
        elif not os.path.exists(path) or open(path, encoding="utf-8").read() != drawn:
            print(f"docs/images/engine_{name}.svg is not what tools/draw_figures.py draws")
            stale += 1
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
