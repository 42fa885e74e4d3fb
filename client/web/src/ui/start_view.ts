// The first view of a scene: the whole of a globe; else from above the relief across the most prominent ground among the scene's landmarks.
import type { Look } from './camera';
import type { Scene } from '@foreland/client';

const kHeadings = 16;

export function startView(scene: Scene): { eye: [number, number, number]; look: Look } {
  if (scene.frame === 'globe') return wholeGlobe(scene);
  const { low, high } = scene.bounds;
  const middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])] as const;
  const across_m = Math.hypot(high[0] - low[0], high[1] - low[1]);
  const relief_m = scene.heights.highest - scene.heights.lowest;
  const target = highestNear(scene, middle, 0.3 * across_m);
  const away_m = Math.min(0.26 * across_m, Math.max(7 * relief_m, 0.05 * across_m));
  const views = Array.from({ length: kHeadings }, (_, i) => viewAcross(scene, target, (2 * Math.PI * i) / kHeadings, away_m));
  const { eye, heading } = views.reduce((best, view) => (view.score > best.score ? view : best));
  const fall_m = eye[2] - (low[2] + 0.6 * (target[2]! - low[2]));
  const pitch = -Math.atan2(fall_m, Math.hypot(target[0]! - eye[0], target[1]! - eye[1]));
  return { eye, look: { heading, pitch } };
}

// Of a globe: all of it, from above the equator.
const kAway = 4.1; // of its radius, from its middle
const kBegin_rad = (15 * Math.PI) / 180; // of longitude: Europe and Africa, on the earth
function wholeGlobe({ bounds: { high } }: Scene): ReturnType<typeof startView> {
  return { eye: [Math.cos(kBegin_rad) * kAway * high[0], Math.sin(kBegin_rad) * kAway * high[0], 0], look: { heading: 0, pitch: -Math.PI / 2 } };
}

// The more of the scene lies ahead, the better; with the sun in the north-west, a look northward shows the slopes best.
function viewAcross(scene: Scene, target: readonly number[], heading: number, away_m: number) {
  const ahead = [Math.sin(heading), Math.cos(heading)] as const;
  const inside = (axis: 0 | 1) =>
    Math.min(Math.max(target[axis]! - away_m * ahead[axis], scene.bounds.low[axis]), scene.bounds.high[axis]);
  const eye: [number, number, number] = [inside(0), inside(1), scene.bounds.high[2] + 0.12 * away_m];
  const reach = ([0, 1] as const).map((axis) => {
    const edge = ahead[axis] > 0 ? scene.bounds.high[axis] : scene.bounds.low[axis];
    return Math.abs(ahead[axis]) < 1e-9 ? Infinity : (edge - eye[axis]) / ahead[axis];
  });
  return { eye, heading, score: Math.min(...reach) * (1 + 0.45 * ahead[1]) };
}

function highestNear(scene: Scene, middle: readonly number[], radius_m: number): readonly number[] {
  const near = scene.landmarks.filter((p) => Math.hypot(p[0] - middle[0]!, p[1] - middle[1]!) <= radius_m);
  return near.reduce<readonly number[]>((best, p) => (p[2] > best[2]! ? p : best), near[0] ?? [...middle, scene.bounds.high[2]]);
}
