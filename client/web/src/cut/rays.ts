// What is met by straight ways through a scene of which a cut has taken something away: what is left of the ground and of objects, and the cut's
// wall. Exactly, of the server; or at once, of the ground that is held.
import type { MapPoint, SightOptions, Terrain, Vector } from '@foreland/client';
import { isKept, spansAlong, type Kept, type Span } from './spans';

// What is shown of a cut.
export interface CutGround extends Kept {
  wall: { foot_m: number }; // below all of the ground along it
}

export interface Way {
  from: Vector; // in the scene's axes
  to: Vector;
}

export interface Met {
  point: Vector;
  is_wall: boolean;
}

type Lines = Pick<Terrain, 'scene' | 'place' | 'toGeodetic' | 'heights' | 'visible'>;
const kTallest_m = 1e4; // of what stands on the ground
const kPieces = 16; // of a way, which bends on the lattice of a curved scene
const kWhole: readonly Span[] = [{ from: 0, to: 1, is_at_wall: false }];

// The first that each way meets; null: nothing; undefined: it is not known. `cut`: null without one.
export async function metExactly(terrain: Lines, cut: CutGround | null, ways: readonly Way[], scene_time_ms?: number): Promise<(Met | null | undefined)[]> {
  const near = ways.map((way) => partNear(terrain, way));
  const spans = near.map((way) => (way ? spansOf(terrain, cut, way) : []));
  const begins = spans.flatMap((of_way, i) => of_way.filter(({ is_at_wall }) => is_at_wall).map(({ from }) => terrain.toGeodetic(pointOn(near[i]!, from))));
  const heights = begins.length > 0 ? await terrain.heights(begins) : []; // NaN beyond the data, where there is no wall
  let wall = 0;
  const stops = spans.map((of_way) => of_way.map(({ is_at_wall }) => (is_at_wall ? stopAt(begins[wall]!.height, heights[wall++]!, cut!) : 'none')));
  const options: SightOptions = { refraction: terrain.scene.frame === 'planar' ? 1 : 0, ...(scene_time_ms === undefined ? {} : { sceneTime: scene_time_ms }) }; // straight, as what is drawn
  const pairs: [MapPoint, MapPoint][] = spans.flatMap((of_way, i) => of_way.filter((_, k) => stops[i]![k] === 'none').map(({ from, to }): [MapPoint, MapPoint] => [
    terrain.toGeodetic(pointOn(near[i]!, from)), terrain.toGeodetic(pointOn(near[i]!, to))]));
  const sights = await terrain.visible(pairs, options);
  let asked = 0;
  return near.map((way, i) => {
    const of_way = spans[i]!.map((span, k) => ({ span, stop: stops[i]![k]!, sight: stops[i]![k] === 'none' ? sights[asked++]! : null }));
    for (const { span, stop, sight } of of_way) {
      if (stop === 'wall') return { point: pointOn(way!, span.from), is_wall: true };
      if (sight && !sight.isKnown) return undefined;
      if (sight?.hit) return { point: sight.hit, is_wall: false };
    }
    return null;
  });
}

// The same of the ground that is held, without objects. `to` is where it ends.
export function metNow(terrain: Pick<Terrain, 'scene' | 'place' | 'raycast'>, cut: CutGround | null, way: Way): Met | null {
  const along = way.to.map((v, i) => v - way.from[i]!) as Vector, length_m = Math.hypot(...along), direction = along.map((v) => v / length_m);
  for (const { from, to, is_at_wall } of spansOf(terrain, cut, way)) {
    const begin = pointOn(way, from), { ground, height } = is_at_wall ? terrain.place(begin)! : { ground: null, height: 0 };
    const stop = ground === null ? 'none' : stopAt(height, ground, cut!);
    if (stop === 'wall') return { point: begin, is_wall: true };
    const hit = stop === 'none' ? terrain.raycast(begin, direction, (to - from) * length_m) : null;
    if (hit) return { point: hit, is_wall: false };
  }
  return null;
}

// Whether a place of the scene is drawn.
export function isShown(terrain: Pick<Terrain, 'place'>, cut: CutGround | null, point: Vector): boolean {
  return cut === null || isKept(cut, terrain.place(point)!.lattice);
}

// From an eye, past all of the scene.
export function wayAlong(terrain: Pick<Terrain, 'scene'>, eye: Vector, direction: Vector): Way {
  const { bounds: { low, high } } = terrain.scene, middle = low.map((v, i) => (v + high[i]!) / 2);
  const far_m = Math.hypot(...eye.map((v, i) => v - middle[i]!)) + Math.hypot(...low.map((v, i) => high[i]! - v));
  return { from: eye, to: eye.map((v, i) => v + far_m * direction[i]!) as Vector };
}

// What of a way over a globe is not above all of its ground, and all that stands there: the rest may be longer than what servers look along, and
// ends higher up. Of other scenes all of it. Null: nothing.
export function partNear({ scene }: Pick<Terrain, 'scene'>, way: Way): Way | null {
  if (scene.frame !== 'globe') return way;
  const radius_m = scene.bounds.high[0] + kTallest_m, along = way.to.map((v, i) => v - way.from[i]!);
  const dot = (a: readonly number[], b: readonly number[]) => a[0]! * b[0]! + a[1]! * b[1]! + a[2]! * b[2]!;
  const length2 = dot(along, along), middle = -dot(way.from, along) / length2, nearest = way.from.map((v, i) => v + middle * along[i]!);
  const half = Math.sqrt((radius_m ** 2 - dot(nearest, nearest)) / length2), from = Math.max(0, middle - half), to = Math.min(1, middle + half);
  return from < to ? { from: pointOn(way, from), to: pointOn(way, to) } : null;
}

// At the wall's plane: the wall is met, or what is above it is open, or nothing is drawn that far down.
function stopAt(height_m: number, ground_m: number, { wall }: CutGround): 'wall' | 'none' | 'below' {
  if (!(height_m < ground_m)) return 'none';
  return height_m >= wall.foot_m ? 'wall' : 'below';
}
function spansOf(terrain: Pick<Terrain, 'scene' | 'place'>, cut: CutGround | null, way: Way): readonly Span[] {
  return cut ? spansAlong(cut, (share) => terrain.place(pointOn(way, share))!.lattice, terrain.scene.frame === 'planar' ? 1 : kPieces) : kWhole;
}
function pointOn({ from, to }: Way, share: number): Vector {
  return from.map((v, i) => v + share * (to[i]! - v)) as Vector;
}
