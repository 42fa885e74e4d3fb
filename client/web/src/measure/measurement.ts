// What is measured: a point, a line or what a line encloses, of the exact ground that the server has.
import type { BothHeights, MapPoint, Terrain, Vector } from '@foreland/client';
import { gridAround, groundInside } from './area';
import { changeInside, type Change, type Dates } from './change';
import { earthOf } from './earth';
import { placesAlong, profileOf, slopeOf, type Profile } from './profile';

export interface Measurement {
  corners: MapPoint[];
  heights: (BothHeights & { height: number })[]; // of the ground at them
  slope: { slope_rad: number; aspect_rad: number | null } | null; // of one point
  profile: Profile | null; // of a line
  straight_m: number; // from the first corner to the last one
  area: { plane_m2: number; slope_m2: number; above_m3: number; below_m3: number } | null; // of three corners and more
  change: Change | null; // likewise, where dates are compared
}

// Where the data's samples are apart.
export function spacingOf(terrain: Terrain): number {
  const { frame, bounds: { low, high }, samples } = terrain.scene;
  if (frame === 'globe') return (3 * Math.PI * high[0]) / samples[0]; // a quarter of the equator is a face, of six
  return Math.hypot(high[0] - low[0], high[1] - low[1]) / Math.hypot(...samples);
}

export async function measure(terrain: Terrain, corners: readonly MapPoint[], dates: Dates | null = null): Promise<Measurement> {
  const heights = await terrain.bothHeights(corners);
  const is_line = corners.length > 1;
  const [slope, profile, area, change] = await Promise.all([
    is_line ? null : measureSlope(terrain, corners[0]!),
    is_line ? measureProfile(terrain, corners) : null,
    corners.length > 2 ? measureArea(terrain, corners, heights.map((h) => h.height)) : null,
    corners.length > 2 && dates ? changeInside(terrain, corners, spacingOf(terrain), dates) : null,
  ]);
  return { corners: [...corners], heights, slope, profile, straight_m: straightOf(terrain, corners, heights), area, change };
}

async function measureSlope(terrain: Terrain, at: MapPoint): Promise<Measurement['slope']> {
  const earth = earthOf(terrain.scene), step_m = spacingOf(terrain);
  const around = await terrain.heights([[1, 0], [-1, 0], [0, 1], [0, -1]].map(([x, y]) => earth.offset(at, x! * step_m, y! * step_m)));
  return around.every(Number.isFinite) ? slopeOf([...around], step_m) : null;
}

async function measureProfile(terrain: Terrain, corners: readonly MapPoint[]): Promise<Profile> {
  const line = placesAlong(earthOf(terrain.scene), corners, spacingOf(terrain));
  return profileOf(line, await terrain.heights(line.places));
}

async function measureArea(terrain: Terrain, ring: readonly MapPoint[], heights: readonly number[]): Promise<Measurement['area']> {
  const earth = earthOf(terrain.scene), plane_m2 = earth.area(ring);
  const grid = gridAround(earth, ring, spacingOf(terrain));
  const { slope_factor, above_m, below_m } = groundInside(grid, await terrain.heights(grid.places), heights);
  return { plane_m2, slope_m2: plane_m2 * slope_factor, above_m3: plane_m2 * above_m, below_m3: plane_m2 * below_m };
}

function straightOf(terrain: Terrain, corners: readonly MapPoint[], heights: readonly { height: number }[]): number {
  const last = corners.length - 1;
  const [from, to] = [0, last].map((i) => pointOn(terrain, corners[i]!, heights[i]!.height));
  return Math.hypot(...from!.map((v, i) => to![i]! - v));
}

// In the scene's axes; at the zero surface beyond the data.
export function pointOn(terrain: Terrain, place: MapPoint, height: number): Vector {
  return terrain.toScene({ ...place, height: Number.isFinite(height) ? height : 0 });
}
