// How much ground a closed line gained and lost from one date to another, in scenes that change in time: of the exact ground at both, which the
// server tells with lines of sight.
import type { MapPoint, Terrain } from '@foreland/client';
import { gridAround, groundInside } from './area';
import { earthOf } from './earth';

const kMost = 4096; // lines of sight of a question (client/js/src/sight.ts)

export interface Dates {
  since_ms: number; // since 1970
  until_ms: number;
}
export interface Change extends Dates {
  gained_m3: number; // where the ground rose
  lost_m3: number; // where it sank
}

export async function changeInside(terrain: Terrain, ring: readonly MapPoint[], spacing_m: number, dates: Dates): Promise<Change> {
  const earth = earthOf(terrain.scene), grid = gridAround(earth, ring, spacing_m), plane_m2 = earth.area(ring);
  const [since, until] = await Promise.all([dates.since_ms, dates.until_ms].map((at) => heightsAt(terrain, grid.places, at)));
  // Against a level plane at nothing, so that the difference alone counts.
  const { above_m, below_m } = groundInside(grid, until!.map((height, i) => height - since![i]!), ring.map(() => 0));
  return { ...dates, gained_m3: plane_m2 * above_m, lost_m3: plane_m2 * below_m };
}

// NaN beyond the data. A line of sight begins on the ground of its date.
async function heightsAt(terrain: Terrain, places: readonly MapPoint[], sceneTime: number): Promise<number[]> {
  const heights: number[] = [];
  for (let i = 0; i < places.length; i += kMost) {
    const pairs = places.slice(i, i + kMost).map((place) => [{ ...place, height: 0 }, { ...place, height: 1 }] as const);
    for (const { from, isKnown } of await terrain.visible(pairs, { above: 'ground', sceneTime })) heights.push(isKnown ? terrain.place(from)!.height : NaN);
  }
  return heights;
}
