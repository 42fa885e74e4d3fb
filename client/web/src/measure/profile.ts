// The ground along a line, exactly as the server has it.
import type { MapPoint } from '@foreland/client';
import type { Earth } from './earth';

const kMost = 4000; // places of a profile
const kLeast = 2; // of each of its parts

export interface Profile {
  places: MapPoint[];
  distances: number[]; // of each place from the first one along the line, metres
  heights: number[]; // of the ground, metres above the zero surface; NaN beyond the data
  length_m: number; // of the line, on the ellipsoid or the map
  surface_m: number; // along the ground; straight where there is none
  rise_m: number; // all that goes up, and all that goes down
  fall_m: number;
  steepest_rad: number;
}

// Where the ground is asked for: at the corners of a line of at least two, and about `spacing_m` apart between them, or farther where the
// line is long.
export function placesAlong(earth: Earth, corners: readonly MapPoint[], spacing_m: number): { places: MapPoint[]; distances: number[] } {
  const lengths = corners.slice(1).map((corner, i) => earth.distance(corners[i]!, corner));
  const length_m = lengths.reduce((sum, part) => sum + part, 0);
  const apart_m = Math.max(spacing_m, length_m / (kMost - corners.length));
  const places: MapPoint[] = [], distances: number[] = [];
  let begun_m = 0;
  lengths.forEach((part_m, i) => {
    const count = Math.max(kLeast, Math.ceil(part_m / apart_m) + 1);
    earth.along(corners[i]!, corners[i + 1]!, count).forEach((place, k) => {
      if (i > 0 && k === 0) return; // the end of the part before
      places.push(place);
      distances.push(begun_m + (part_m * k) / (count - 1));
    });
    begun_m += part_m;
  });
  return { places, distances };
}

export function profileOf({ places, distances }: { places: MapPoint[]; distances: number[] }, heights: ArrayLike<number>): Profile {
  let [surface_m, rise_m, fall_m, steepest_rad] = [0, 0, 0, 0];
  for (let i = 1; i < heights.length; ++i) {
    const ahead_m = distances[i]! - distances[i - 1]!, up_m = heights[i]! - heights[i - 1]!;
    const is_known = Number.isFinite(up_m);
    surface_m += is_known ? Math.hypot(ahead_m, up_m) : ahead_m;
    if (!is_known) continue;
    rise_m += Math.max(up_m, 0);
    fall_m += Math.max(-up_m, 0);
    if (ahead_m > 0) steepest_rad = Math.max(steepest_rad, Math.atan2(Math.abs(up_m), ahead_m));
  }
  return { places, distances, heights: Array.from(heights), length_m: distances[distances.length - 1] ?? 0, surface_m, rise_m, fall_m, steepest_rad };
}

// Slope and aspect of the ground from its heights one step to the east, west, north and south. Aspect is where it falls, clockwise from
// north; null on the level.
export function slopeOf([east, west, north, south]: readonly number[], step_m: number): { slope_rad: number; aspect_rad: number | null } {
  const [dx, dy] = [(east! - west!) / (2 * step_m), (north! - south!) / (2 * step_m)];
  const steepness = Math.hypot(dx, dy);
  const aspect = Math.atan2(-dx, -dy);
  return { slope_rad: Math.atan(steepness), aspect_rad: steepness === 0 ? null : (aspect + 2 * Math.PI) % (2 * Math.PI) };
}
