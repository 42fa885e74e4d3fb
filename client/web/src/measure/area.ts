// The ground inside of a closed line: how large it is on the slope, and how much of it lies above the plane through the line's corners and
// how much is missing below it.
import type { MapPoint } from '@foreland/client';
import type { Earth } from './earth';

const kMost = 40_000; // places at which the ground is asked for

type Point = readonly [x: number, y: number]; // metres east and north of the first corner, on the plane that touches there

export interface AreaGrid {
  places: MapPoint[]; // row by row from the south, each from the west
  across: number; // places in a row
  steps: readonly [east_m: number, north_m: number];
  points: Point[]; // of the places
  corners: Point[];
}
export interface GroundInside {
  slope_factor: number; // the area on the slope, as a multiple of that in the plane
  above_m: number; // mean height above the plane through the corners, where the ground is above it and nothing elsewhere
  below_m: number; // the same below it
}

// The middles of the cells into which the box about the line is divided, nearly square and at least `spacing_m` apart, or farther where
// it is large.
export function gridAround(earth: Earth, ring: readonly MapPoint[], spacing_m: number): AreaGrid {
  const first = ring[0]!, corners = ring.map((place) => earth.towards(first, place));
  const [east, north] = [0, 1].map((k) => corners.map((corner) => corner[k]!)) as [number[], number[]];
  const low = [Math.min(...east), Math.min(...north)], size = [Math.max(...east) - low[0]!, Math.max(...north) - low[1]!];
  const least_m = Math.max(spacing_m, Math.sqrt((size[0]! * size[1]!) / kMost), Math.max(...size) / 1000);
  const cells = size.map((side) => Math.ceil(side / least_m)), steps = size.map((side, k) => side / cells[k]!) as [number, number];
  const [across, up] = cells.map((count) => count + 2); // one beyond on each side
  const points: Point[] = [];
  for (let j = 0; j < up!; ++j) for (let i = 0; i < across!; ++i) points.push([low[0]! + (i - 0.5) * steps[0], low[1]! + (j - 0.5) * steps[1]]);
  return { places: points.map(([x, y]) => earth.offset(first, x, y)), across: across!, steps, points, corners };
}

export function groundInside(grid: AreaGrid, heights: ArrayLike<number>, corner_heights: readonly number[]): GroundInside {
  const { across, steps, points, corners } = grid;
  const plane = planeThrough(corners, corner_heights);
  let [slopes, sloped, above, below, inside] = [0, 0, 0, 0, 0];
  points.forEach((point, i) => {
    const height = heights[i]!;
    if (!Number.isFinite(height) || !isInside(point, corners)) return;
    ++inside;
    const over = height - plane(point);
    above += Math.max(over, 0);
    below += Math.max(-over, 0);
    const steep = Math.hypot((heights[i + 1]! - heights[i - 1]!) / steps[0], (heights[i + across]! - heights[i - across]!) / steps[1]) / 2;
    if (!Number.isFinite(steep)) return;
    slopes += Math.hypot(1, steep);
    ++sloped;
  });
  return { slope_factor: sloped > 0 ? slopes / sloped : 1, above_m: above / Math.max(inside, 1), below_m: below / Math.max(inside, 1) };
}

function isInside([x, y]: Point, corners: readonly Point[]): boolean {
  let is_in = false;
  corners.forEach(([x0, y0], i) => {
    const [x1, y1] = corners[(i + 1) % corners.length]!;
    if (y0 > y !== y1 > y && x < x0 + ((x1 - x0) * (y - y0)) / (y1 - y0)) is_in = !is_in;
  });
  return is_in;
}

// Of least squares; level at the corners' mean height where they lie on one line.
function planeThrough(corners: readonly Point[], heights: readonly number[]): (point: Point) => number {
  const n = corners.length, mean = (values: readonly number[]) => values.reduce((a, b) => a + b, 0) / n;
  const [mx, my, mh] = [mean(corners.map((c) => c[0])), mean(corners.map((c) => c[1])), mean(heights)];
  let [xx, xy, yy, xh, yh] = [0, 0, 0, 0, 0];
  corners.forEach(([px, py], i) => {
    const [x, y, h] = [px - mx, py - my, heights[i]! - mh];
    [xx, xy, yy, xh, yh] = [xx + x * x, xy + x * y, yy + y * y, xh + x * h, yh + y * h];
  });
  const det = xx * yy - xy * xy;
  if (!(det > 1e-9 * (xx + yy) ** 2)) return () => mh;
  const [a, b] = [(xh * yy - yh * xy) / det, (yh * xx - xh * xy) / det];
  return ([x, y]) => mh + a * (x - mx) + b * (y - my);
}
