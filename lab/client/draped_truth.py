#!/usr/bin/env python3
"""Judges where lines are drawn on the ground, by NumPy on a raster that GDAL reads. lab/client/draped.mjs runs it.

    draped_truth.py lines RASTER COUNT SEED          lines over the raster, each as its samples' places on the map
    draped_truth.py judge RASTER FILE COUNT SEED     FILE: frames with their cameras and what is drawn of the lines

COUNT samples are drawn at random, each a sample of the raster that a line passes, so that no rule between samples matters. In a frame a sample is judged
where a camera over the raster would surely see it: no ground in front comes near the line of sight to it, nor does the ground fall away behind it, and nothing
else of the lines is near. What is off is how far the middle of what is drawn about the sample lies from the line's place on the picture, across the line.
Prints JSON.
"""
import json
import sys

import numpy as np

from raster_truth import Raster

APART = 48  # samples between lines that go the same way
FACING = 0.12  # least share of a sight that goes into the ground, not along it
BENT_PX = 0.4  # how far a line may be from straight within reach of a sample
LEAST_SHARE = 1.5  # of pixels, that are drawn about a sample


def nodes(raster):
    """Columns and rows of each line's samples."""
    rows, columns = raster.samples.shape
    lines = [(np.arange(columns), np.full(columns, j)) for j in range(APART // 2, rows, APART)]
    lines += [(np.full(rows, i), np.arange(rows)) for i in range(APART // 2, columns, APART)]
    for first in range(-rows, columns, 3 * APART):
        for way in (1, -1):
            i = np.arange(first, first + rows)
            j = np.arange(rows)[::way]
            inside = (i >= 0) & (i < columns)
            if np.sum(inside) > 3 * APART:
                lines.append((i[inside], j[inside]))
    return lines


def places(raster, line):
    return raster.x0 + line[0] * raster.dx, raster.y0 + line[1] * raster.dy


def chosen(raster, count, seed):
    """Line and place in it of COUNT samples, none beside a line's end."""
    ends = 8
    of_lines = [(n, k) for n, line in enumerate(nodes(raster)) for k in range(ends, len(line[0]) - ends)]
    picks = np.random.default_rng(seed).choice(len(of_lines), min(count, len(of_lines)), replace=False)
    return np.array([of_lines[p] for p in picks])


class Camera:
    """A pinhole; pixels count from the picture's lower left corner."""

    def __init__(self, frame, fov_rad, origin):
        self.eye = np.array(frame["eye"]) + origin
        self.size = np.array([frame["width"], frame["height"]])
        self.focal = self.size[1] / 2 / np.tan(fov_rad / 2)
        x, y, z, w = frame["orientation"]
        self.right = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
        self.up = np.array([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)])
        self.ahead = np.cross(self.up, self.right)

    def project(self, points):
        """Pixels, and depths."""
        way = points - self.eye
        depth = way @ self.ahead
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.size / 2 + self.focal * np.stack([way @ self.right, way @ self.up], -1) / depth[..., None], depth


def ground(raster, x, y):
    return np.stack([x, y, raster.at(x, y)], -1)


def surely_seen(raster, camera, points, room_px):
    """Of points on the ground: nothing in front of them comes within room_px of hiding them, and the ground goes on rising behind them."""
    step = abs(raster.dx)
    flat = camera.eye[:2] - points[:, :2]
    reach = np.hypot(*flat.T)
    towards = flat / reach[:, None]
    normal = np.stack([raster.at(points[:, 0] - step, points[:, 1]) - raster.at(points[:, 0] + step, points[:, 1]),
                       raster.at(points[:, 0], points[:, 1] - step) - raster.at(points[:, 0], points[:, 1] + step), np.full(len(points), 2 * step)], -1)
    sight = camera.eye - points
    facing = np.sum(normal * sight, -1) / np.linalg.norm(normal, axis=-1) / np.linalg.norm(sight, axis=-1)
    seen = facing > FACING
    raised = np.arctan2(points[:, 2] - camera.eye[2], reach)

    def below(k):
        """How many pixels the ground so many steps in front is below a point, or more where that is beside the picture's middle; and how far it is."""
        at = points[:, :2] + towards * (k * step)
        along = reach - k * step
        return camera.focal * (raised - np.arctan2(raster.at(at[:, 0], at[:, 1]) - camera.eye[2], along)), along

    last, is_clear = np.zeros(len(points)), np.zeros(len(points), bool)
    for k in range(1, int(np.max(reach, initial=0) / step)):
        px, along = below(k)
        beyond = along < 1.5 * step  # the eye
        seen &= np.where(is_clear, px > room_px, px > last) | beyond
        is_clear |= px > room_px
        last = np.where(beyond, last, px)
        if not np.any(seen & ~beyond):
            break
    last, is_clear = np.zeros(len(points)), np.zeros(len(points), bool)
    for k in range(1, 40):
        px, _ = below(-k)
        seen &= is_clear | (-px > last)
        is_clear |= -px > room_px
        last = -px
    return seen & is_clear


def near_to(raster, camera, lines, reach_px):
    """For each pixel: which line passes near it; 0 none, -1 several."""
    width, height = camera.size
    near = np.zeros((height, width), np.int32)
    spread = np.arange(-reach_px, reach_px + 1)
    for n, points in enumerate(lines):
        pixel, depth = camera.project(points)
        inside = (depth > 1) & np.all((pixel > -reach_px) & (pixel < camera.size + reach_px), -1)
        mask = np.zeros_like(near, bool)
        at = np.unique(np.floor(pixel[inside]).astype(int), axis=0)
        if len(at) == 0:
            continue
        x = np.clip(at[:, 0, None, None] + spread[None, :, None], 0, width - 1)
        y = np.clip(at[:, 1, None, None] + spread[None, None, :], 0, height - 1)
        mask[y, x] = True
        near[mask] = np.where(near[mask] == 0, n + 1, -1)
    return near


def judge_frame(raster, camera, frame, lines, picks, line_px):
    """How far each sample that can be judged is off, in pixels, and which those are."""
    reach = frame["tau_px"] + 1 + line_px / 2 + 1.5
    points = np.array([lines[n][k] for n, k in picks])
    pixel, depth = camera.project(points)
    inside = np.flatnonzero((depth > 5) & np.all((pixel > reach + 2) & (pixel < camera.size - reach - 2), -1) & np.isfinite(points[:, 2]))
    inside = inside[surely_seen(raster, camera, points[inside], frame["tau_px"] + 2)]
    near = near_to(raster, camera, lines, int(np.ceil(reach)) + 1)
    shares = np.zeros((camera.size[1], camera.size[0]))
    shares.flat[frame["pixels"]] = np.array(frame["shares"]) / 255
    off, judged = [], []
    r = int(np.ceil(reach)) + 1
    for s in inside:
        n, k = picks[s]
        x, y = np.floor(pixel[s]).astype(int)
        if near[y, x] != n + 1:
            continue
        around, behind = camera.project(lines[n][max(k - 200, 0):k + 201])
        from_sample = around - pixel[s]
        close = (np.hypot(*from_sample.T) < reach + 1) & (behind > 0)
        ends = np.flatnonzero(close)
        along = around[min(ends[-1] + 1, len(around) - 1)] - around[max(ends[0] - 1, 0)]
        length = np.hypot(*along)
        if length < 1e-6:
            continue
        across = np.array([-along[1], along[0]]) / length
        if np.max(np.abs(from_sample[close] @ across)) > BENT_PX:
            continue
        gx, gy = np.meshgrid(np.arange(x - r, x + r + 1), np.arange(y - r, y + r + 1))
        rel = np.stack([gx + 0.5, gy + 0.5], -1) - pixel[s]
        a, b = rel @ (along / length), rel @ across
        share = shares[gy, gx] * ((np.abs(a) < 2) & (np.abs(b) < reach))
        drawn = np.sum(share)
        off.append(abs(np.sum(share * b) / drawn) if drawn > LEAST_SHARE else np.inf)
        judged.append(s)
    return off, judged


def judge(raster, path, count, seed):
    with open(path) as file:
        told = json.load(file)
    picks = chosen(raster, count, seed)
    lines = [ground(raster, *places(raster, line)) for line in nodes(raster)]
    offs, beyond, samples, meshes = [], [], set(), set()
    for frame in told["frames"]:
        camera = Camera(frame, told["fov_rad"], np.array(told["origin"]))
        off, judged = judge_frame(raster, camera, frame, lines, picks, told["line_px"])
        offs += off
        beyond += [v - frame["tau_px"] for v in off]
        samples.update(judged)
        meshes.add(frame["mesh_version"])
    offs, beyond = np.array(offs), np.array(beyond)
    drawn = offs[np.isfinite(offs)]
    return {
        "frames": len(told["frames"]), "meshes": len(meshes), "samples": len(picks), "samples_judged": len(samples), "places": len(offs),
        "over": int(np.sum(beyond > 1)), "not_drawn": int(np.sum(~np.isfinite(offs))), "largest_px": float(np.max(drawn, initial=0)), "largest_beyond_px": float(np.max(beyond[np.isfinite(beyond)], initial=-1)),
        "p99_px": float(np.quantile(drawn, 0.99)) if len(drawn) else None, "mean_px": float(np.mean(drawn)) if len(drawn) else None,
    }


def main(kind, path, *more):
    raster = Raster(path)
    if kind == "lines":
        return [np.stack(places(raster, line), -1).tolist() for line in nodes(raster)]
    return judge(raster, more[0], int(more[1]), int(more[2]))


if __name__ == "__main__":
    print(json.dumps(main(*sys.argv[1:])))
