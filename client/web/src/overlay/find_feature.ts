// Which feature lies at a place that was clicked. Pure.
import type { Feature, Laid, Places } from './feature';
import { distanceTo, type Point } from './ground_grid';

// A place on the lattice and how pixels of the screen follow from what is about it: a matrix by columns.
export interface Pointed {
  at: Point;
  to_px: readonly [number, number, number, number];
}

// Of two places beside a place, each `step_px` pixels away: to the right of it, and below.
export function pointedAt(at: Point, right: Point, below: Point, step_px: number): Pointed {
  const [a, b, c, d] = [right[0] - at[0], right[1] - at[1], below[0] - at[0], below[1] - at[1]];
  const det = (a * d - b * c) / step_px;
  return { at, to_px: det === 0 ? [0, 0, 0, 0] : [d / det, -b / det, -c / det, a / det] };
}

// The last one, which is drawn above the others, whose line is at most `near_px` away or whose area is about the place. `laid` is each feature
// on the lattice.
export function featureAt(features: readonly Feature[], laid: readonly Laid[], pointed: Pointed, near_px: number): Feature | null {
  for (let i = features.length; i-- > 0;) {
    const { kind, style } = features[i]!, { outline, rings } = laid[i]!;
    if (kind === 'point') continue;
    if (outline.some((part) => isNear(part, pointed, near_px + style.stroke_px / 2)) || isAbout(rings, pointed.at)) return features[i]!;
  }
  return null;
}

function isNear(part: Places, { at, to_px: [a, b, c, d] }: Pointed, near_px: number): boolean {
  if (a === 0 && b === 0 && c === 0 && d === 0) return false;
  let before: Point | null = null;
  for (let i = 0; i < part.length; i += 2) {
    const [x, y] = [part[i]! - at[0], part[i + 1]! - at[1]];
    const here: Point = [a * x + c * y, b * x + d * y];
    if (before && distanceTo([0, 0], before, here) <= near_px) return true;
    before = here;
  }
  return false;
}

// Inside of an odd number of rings.
export function isAbout(rings: readonly Places[], [x, y]: Point): boolean {
  let crossings = 0;
  for (const ring of rings)
    for (let i = 0, j = ring.length - 2; i < ring.length; j = i, i += 2) {
      const [ax, ay, bx, by] = [ring[j]!, ring[j + 1]!, ring[i]!, ring[i + 1]!];
      if (ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay)) ++crossings;
    }
  return crossings % 2 === 1;
}
