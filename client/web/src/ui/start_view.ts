// The first view of a scene: from above the relief across the most prominent ground among the welcome's landmarks.
import type { Look } from './camera';
import type { Welcome } from '../core/values';

const kHeadings = 16;

export function startView(welcome: Welcome): { eye: [number, number, number]; look: Look } {
  const { low, high } = welcome;
  const middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])] as const;
  const across_m = Math.hypot(high[0] - low[0], high[1] - low[1]);
  const relief_m = welcome.highest_m - welcome.lowest_m;
  const target = highestNear(welcome, middle, 0.3 * across_m);
  const away_m = Math.min(0.26 * across_m, Math.max(7 * relief_m, 0.05 * across_m));
  const views = Array.from({ length: kHeadings }, (_, i) => viewAcross(welcome, target, (2 * Math.PI * i) / kHeadings, away_m));
  const { eye, heading } = views.reduce((best, view) => (view.score > best.score ? view : best));
  const fall_m = eye[2] - (low[2] + 0.6 * (target[2]! - low[2]));
  const pitch = -Math.atan2(fall_m, Math.hypot(target[0]! - eye[0], target[1]! - eye[1]));
  return { eye, look: { heading, pitch } };
}

// The more of the scene lies ahead, the better; with the sun in the north-west, a look northward shows the slopes best.
function viewAcross(welcome: Welcome, target: readonly number[], heading: number, away_m: number) {
  const ahead = [Math.sin(heading), Math.cos(heading)] as const;
  const inside = (axis: 0 | 1) =>
    Math.min(Math.max(target[axis]! - away_m * ahead[axis], welcome.low[axis]), welcome.high[axis]);
  const eye: [number, number, number] = [inside(0), inside(1), welcome.high[2] + 0.12 * away_m];
  const reach = ([0, 1] as const).map((axis) => {
    const edge = ahead[axis] > 0 ? welcome.high[axis] : welcome.low[axis];
    return Math.abs(ahead[axis]) < 1e-9 ? Infinity : (edge - eye[axis]) / ahead[axis];
  });
  return { eye, heading, score: Math.min(...reach) * (1 + 0.45 * ahead[1]) };
}

function highestNear(welcome: Welcome, middle: readonly number[], radius_m: number): number[] {
  const near = welcome.landmarks.filter((p) => Math.hypot(p[0] - middle[0]!, p[1] - middle[1]!) <= radius_m);
  return near.reduce<number[]>((best, p) => (p[2] > best[2]! ? p : best), near[0] ?? [...middle, welcome.high[2]]);
}
