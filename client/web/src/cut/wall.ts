// The wall that a cut shows: along its ring, from the exact ground, as the server has it, down to below all of that.
import type { MapPoint, Terrain, Vector } from '@foreland/client';
import { latticeOf } from '../overlay/on_lattice';
import { alongEdges, type At } from './ring';

const kMostColumns = 8000;
const kDeeper = 0.35, kLeastDepth = 0.02; // below the lowest ground along it: of what that rises, and of its extent

export interface Wall {
  origin: Vector; // in the scene's axes
  positions: Float32Array; // from there
  heights: Float32Array; // of each vertex, and how far below the ground it is: metres
  indices: Uint32Array;
  columns: number; // where there is ground
  span_m: number; // from its foot to the highest ground along it
  foot_m: number; // height of its foot
}

// The place of a position on the lattice: latticeOf the other way round, for maps that are regular on it, as those of all scenes but globes are.
export function mapOf(terrain: Terrain): (at: At) => MapPoint {
  const { low, high } = terrain.scene.bounds, middle = terrain.place(low.map((v, i) => (v + high[i]!) / 2))!;
  const is_geographic = 'lat' in middle, step = is_geographic ? 0.01 : 100;
  const [x, y] = is_geographic ? [middle.lon, middle.lat] : [middle.easting, middle.northing];
  const point = (u: number, v: number): MapPoint => (is_geographic ? { lon: u, lat: v } : { easting: u, northing: v });
  const [from, east, north] = [point(x, y), point(x + step, y), point(x, y + step)].map((place) => latticeOf(terrain, place)) as [At, At, At];
  const [a, c] = [east[0] - from[0], east[1] - from[1]], [b, d] = [north[0] - from[0], north[1] - from[1]], det = a * d - b * c;
  return ([column, row]) => {
    const [dx, dy] = [column - from[0], row - from[1]];
    return point(x + (step * (d * dx - b * dy)) / det, y + (step * (a * dy - c * dx)) / det);
  };
}

export async function wallAlong(terrain: Terrain, ring: readonly At[]): Promise<Wall> {
  const toMap = mapOf(terrain), edges = alongEdges(ring, kMostColumns).map((edge) => edge.map(toMap));
  const ground = await terrain.heights(edges.flat());
  return wallOf(edges, ground, (place) => terrain.toScene(place));
}

// `ground` at all places of the edges, one after another; NaN beyond the data.
export function wallOf(edges: readonly MapPoint[][], ground: ArrayLike<number>, toScene: (place: MapPoint) => Vector): Wall {
  const known = Array.from(ground).filter(Number.isFinite), lowest = Math.min(...known), highest = Math.max(...known);
  const places = edges.flat(), first = places.findIndex((_, i) => Number.isFinite(ground[i]!));
  if (first < 0) return { origin: [0, 0, 0], positions: new Float32Array(), heights: new Float32Array(), indices: new Uint32Array(), columns: 0, span_m: 1, foot_m: Infinity };
  const origin = toScene({ ...places[first]!, height: ground[first]! });
  const away = (point: Vector) => Math.hypot(point[0] - origin[0], point[1] - origin[1]);
  const extent_m = Math.max(...places.map((place, i) => (Number.isFinite(ground[i]!) ? away(toScene({ ...place, height: ground[i]! })) : 0)));
  const foot = lowest - Math.max(kDeeper * (highest - lowest), kLeastDepth * extent_m);
  const positions: number[] = [], heights: number[] = [], indices: number[] = [];
  let [at, columns] = [0, 0];
  for (const edge of edges) {
    let has_before = false;
    for (const place of edge) {
      const height = ground[at++]!;
      if (!Number.isFinite(height)) {
        has_before = false;
        continue;
      }
      for (const h of [height, foot]) {
        positions.push(...toScene({ ...place, height: h }).map((v, i) => v - origin[i]!));
        heights.push(h, height - h);
      }
      if (has_before) indices.push(...[-2, -1, 0, 0, -1, 1].map((i) => 2 * columns + i));
      has_before = true;
      ++columns;
    }
  }
  return { origin, positions: Float32Array.from(positions), heights: Float32Array.from(heights), indices: Uint32Array.from(indices), columns, span_m: highest - foot, foot_m: foot };
}
