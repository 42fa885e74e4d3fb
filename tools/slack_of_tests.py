"""How long the result of a refinement test is sure to hold, for the figures: the two simpler sensitivities of MotionMargin::testResult in
proto/refine, for planar terrain, one node at a time."""

import math

import section as steps
from terrain import ERROR_M

MOTION, TOWARDS_SIDE_PLANE = range(2)  # Sensitivity in motion_margin.h


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


class Camera:
    def __init__(self, frame, view):
        self.view, self.test = view, steps.Test(frame, view)

    def bound_to(self, next_view):
        """(metres, metres per metre of distance) for each sensitivity, from this view to the next; None if the lenses differ."""
        v, w, t = self.view, next_view, self.test
        if (v.width, v.height, v.fov) != (w.width, w.height, w.fov):
            return None
        move = [b - a for a, b in zip(v.pose.eye, w.pose.eye)]
        x, y, z = dot(move, t.right), dot(move, t.up), dot(move, t.forward)
        moved, region = math.hypot(*move), abs(w.region_radius - v.region_radius)
        beside = max(0.0, abs(x) * t.cos_x - z * t.sin_x, abs(y) * t.cos_y - z * t.sin_y) + moved * t.sin_w
        cosine = min(1.0, abs(dot(v.pose.orientation, w.pose.orientation)))
        turned, scaled = 2 * math.acos(cosine) + abs(w.region_angle - v.region_angle), abs(w.tau / v.tau - 1)
        return [(moved + region, turned + scaled), (beside + region, turned)]

    def longest(self, sphere, bound, pace):
        """(sensitivity, slack, distance, steps at this pace) of the sensitivity that lasts longest."""
        t = self.test
        x, y, z, h = t.view_position(sphere)
        R, K = sphere[4] + t.region_radius, ERROR_M[bound] * t.scale
        depth, side = t.depth(x, y, z, R, 0.1), t.facing(x, y, z) + R
        b, c = 2 * depth + K, K * (h + R) - depth * depth
        seen = min(K * t.corner - depth, 2 * c / (b + math.sqrt(max(0.0, b * b + 4 * c))))
        slacks = [min(seen, side), 0.0] if t.passes(sphere, bound) else [-seen, -side]
        distance = math.sqrt(x * x + y * y + z * z)
        lasting = [s / (fixed + share * distance + 1e-9) for s, (fixed, share) in zip(slacks, pace)]
        kind = lasting.index(max(lasting))
        return kind, max(0.0, slacks[kind]), distance, max(lasting)


def tests_per_step(flight):
    """{keyframe index: frontier entries whose slack the step used up}."""
    counts, held, camera = {}, {}, None
    for k in flight.keyframes:
        bound = camera.bound_to(k.view) if camera else None
        camera = Camera(flight.section.frame, k.view)
        fresh, tested = {}, 0
        for slot, error in k.bounds.items():
            key = slot, error, slot in k.heights
            kind, slack, most = held.get(key, (MOTION, 0.0, 0.0))
            slack = slack - (bound[kind][0] + bound[kind][1] * most) if bound else -1.0
            if slack <= 0:
                tested += 1
                kind, slack, distance, _ = camera.longest(k.spheres[slot], error, bound or [(1, 0)] * 2)
                most = distance + slack
            fresh[key] = kind, slack, most
        held, counts[k.index] = fresh, tested
    return counts
