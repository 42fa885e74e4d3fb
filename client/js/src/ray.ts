// Where a ray meets the ground that is held.
import type { MapPosition } from './core/values.js';
import type { Scene, Vector } from './scene.js';

const kRaySteps = 4096;

// Steps along the ray through the scene's box until it is below the ground, then halves.
/** @internal */
export function rayOnGround(scene: Scene, placeAt: (point: Vector) => MapPosition | null, origin: readonly number[], direction: readonly number[], far: number): Vector | null {
  const length = Math.hypot(...direction);
  if (!(length > 0)) return null;
  const at = (t: number): Vector => [0, 1, 2].map((i) => origin[i]! + (t / length) * direction[i]!) as Vector;
  const [begin, end] = insideBox(scene, at, far);
  const above = (t: number) => {
    const place = placeAt(at(t));
    return place === null || place.ground_m === null ? null : place.height_m - place.ground_m;
  };
  let before: number | null = null;
  for (let i = 0; i <= kRaySteps && begin < end; ++i) {
    const t = begin + ((end - begin) * i) / kRaySteps;
    const height = above(t);
    if (height !== null && height <= 0) return before === null ? at(t) : at(crossing(above, before, t));
    before = height === null ? null : t;
  }
  return null;
}
function insideBox({ bounds: { low, high } }: Scene, at: (t: number) => Vector, far: number): [number, number] {
  let [begin, end] = [0, far];
  const [from, step] = [at(0), at(1)];
  for (const i of [0, 1, 2] as const) {
    const [a, b] = [low[i] - 1, high[i] + 1].map((v) => (v - from[i]) / (step[i] - from[i])) as [number, number];
    if (step[i] === from[i]) {
      if (from[i] < low[i] - 1 || from[i] > high[i] + 1) return [0, 0];
      continue;
    }
    [begin, end] = [Math.max(begin, Math.min(a, b)), Math.min(end, Math.max(a, b))];
  }
  return [begin, end];
}
function crossing(above: (t: number) => number | null, outside: number, inside: number): number {
  for (let i = 0; i < 40; ++i) {
    const middle = 0.5 * (outside + inside);
    if ((above(middle) ?? 0) > 0) outside = middle;
    else inside = middle;
  }
  return inside;
}
