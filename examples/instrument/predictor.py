#!/usr/bin/env python3
"""A predictor: even motion and turn, as over the last 80 ms, which is `--predictors velocity`. docs/INSTRUMENT.md tells the questions."""
import json
import sys


def after(p, q):  # the turn from the orientation q to p: p times the conjugate of q
    (w, x, y, z), (a, b, c, d) = p, (q[0], -q[1], -q[2], -q[3])
    return [w * a - x * b - y * c - z * d, w * b + x * a + y * d - z * c, w * c + y * a + z * b - x * d, w * d + z * a + x * c - y * b]


def motion(poses):
    last, before = poses[-1], next((p for p in poses[::-1] if poses[-1]["time_us"] - p["time_us"] >= 80_000), poses[0])
    span_s = (last["time_us"] - before["time_us"]) * 1e-6
    if last is before:
        return {"velocity_m_s": [0, 0, 0], "acceleration_m_s2": [0, 0, 0], "rotation": [1, 0, 0, 0], "span_s": 1}
    velocity = [(a - b) / span_s for a, b in zip(last["eye_m"], before["eye_m"])]
    return {"velocity_m_s": velocity, "acceleration_m_s2": [0, 0, 0], "rotation": after(last["orientation"], before["orientation"]), "span_s": span_s}


poses, greeting = {}, json.loads(sys.stdin.readline())
print(json.dumps({"foreland": 1}), flush=True)
for question in map(json.loads, sys.stdin):
    for pose in question["poses"]:
        known = [] if pose["jumped"] else poses.get(question["connection"], [])[-511:]
        poses[question["connection"]] = [*known, pose]
    print(json.dumps(motion(poses[question["connection"]])), flush=True)
