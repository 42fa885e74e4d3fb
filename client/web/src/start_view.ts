// Where a visit begins: beside the most prominent ground that the welcome tells of, looking across it towards the middle.
import type { Look } from './camera';
import type { Welcome } from './core';

export function startView(welcome: Welcome): { eye: [number, number, number]; look: Look } {
  const middle = [0, 1].map((axis) => 0.5 * (welcome.low[axis]! + welcome.high[axis]!));
  const across_m = Math.hypot(welcome.high[0] - welcome.low[0], welcome.high[1] - welcome.low[1]);
  const relief_m = welcome.highest_m - welcome.lowest_m;
  const target = highestNear(welcome, middle, 0.3 * across_m);
  const away_m = Math.min(0.26 * across_m, Math.max(7 * relief_m, 0.05 * across_m));
  // From the south-east of it, so that the sun in the north-west shapes the slopes.
  const inside = (v: number, axis: 0 | 1) => Math.min(Math.max(v, welcome.low[axis]), welcome.high[axis]);
  const eye: [number, number, number] = [
    inside(target[0]! + 0.45 * away_m, 0),
    inside(target[1]! - 0.89 * away_m, 1),
    welcome.high[2] + 0.12 * away_m,
  ];
  const ahead = [target[0]! - eye[0], target[1]! - eye[1]];
  const fall = eye[2] - (welcome.low[2] + 0.6 * (target[2]! - welcome.low[2]));
  return { eye, look: { heading: Math.atan2(ahead[0]!, ahead[1]!), pitch: -Math.atan2(fall, Math.hypot(...ahead)) } };
}

function highestNear(welcome: Welcome, middle: readonly number[], radius_m: number): number[] {
  const near = welcome.landmarks.filter((p) => Math.hypot(p[0] - middle[0]!, p[1] - middle[1]!) <= radius_m);
  return near.reduce<number[]>((best, p) => (p[2] > best[2]! ? p : best), near[0] ?? [...middle, welcome.high[2]]);
}
