// Two fingers on the window, over a map or a globe.

export type Finger = readonly [number, number]; // pixels

export interface Pinch {
  apart: number;
  angle: number;
  middle: [number, number];
}

export function pinchOf(a: Finger, b: Finger): Pinch {
  return { apart: Math.hypot(b[0] - a[0], b[1] - a[1]), angle: Math.atan2(b[1] - a[1], b[0] - a[0]), middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] };
}

// What they did from one to the other: by what factor they near, by what angle they twist, and how far their middle went.
export function motionOf(before: Pinch, now: Pinch): { factor: number; twist: number; right_px: number; down_px: number } {
  const turn = now.angle - before.angle;
  return {
    factor: before.apart / Math.max(now.apart, 1), twist: Math.atan2(Math.sin(turn), Math.cos(turn)),
    right_px: now.middle[0] - before.middle[0], down_px: now.middle[1] - before.middle[1],
  };
}
