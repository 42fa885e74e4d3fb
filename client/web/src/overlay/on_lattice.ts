// Features on a scene's lattice, where the ground is shaded.
import type { MapPoint, Terrain } from '@foreland/client';
import type { Feature, Laid, Places } from './feature';
import type { Point } from './ground_grid';
import { areaOf, kOften, piecesOf, type Faces } from './on_faces';

function mapPointAt(places: Places, i: number, is_geographic: boolean): MapPoint {
  const [x, y] = [places[2 * i]!, places[2 * i + 1]!];
  return is_geographic ? { lon: x, lat: y } : { easting: x, northing: y };
}

export function mapPointsOf(terrain: Terrain, places: Places): MapPoint[] {
  const is_geographic = terrain.scene.frame !== 'planar';
  return Array.from({ length: places.length / 2 }, (_, i) => mapPointAt(places, i, is_geographic));
}

export function latticeOf(terrain: Terrain, place: MapPoint): readonly [number, number] {
  return terrain.place(terrain.toScene({ ...place, height: 0 }))!.lattice;
}

// Each feature's. A generator, for slices (slices.ts).
export function* onLattice(terrain: Terrain, features: readonly Feature[]): Generator<void, Laid[]> {
  const of_features: Laid[] = [], layOut = terrain.scene.frame === 'globe' ? onFaces : onPlane;
  for (const feature of features) of_features.push(yield* layOut(terrain, feature));
  return of_features;
}

function* onPlane(terrain: Terrain, { kind, parts }: Feature): Generator<void, Laid> {
  const laid: Places[] = [], is_geographic = terrain.scene.frame !== 'planar';
  for (const part of parts) {
    const places = new Float64Array(part.length);
    for (let i = 0; 2 * i < part.length; ++i) {
      places.set(latticeOf(terrain, mapPointAt(part, i, is_geographic)), 2 * i);
      if (i % kOften === 0) yield;
    }
    laid.push(places);
    yield;
  }
  return { outline: laid, rings: kind === 'area' ? laid : [] };
}

function* onFaces(terrain: Terrain, { kind, parts }: Feature): Generator<void, Laid> {
  const faces: Faces = { at: (lon, lat) => latticeOf(terrain, { lon, lat }), side: terrain.scene.samples[1] - 1 };
  const { outline, rings } = kind === 'area' ? yield* areaOf(faces, parts) : { outline: yield* piecesOfAll(faces, parts), rings: [] };
  return { outline: outline.map(flat), rings: rings.map(flat) };
}
function* piecesOfAll(faces: Faces, lines: readonly Places[]): Generator<void, Point[][]> {
  const pieces: Point[][] = [];
  for (const line of lines) pieces.push(...(yield* piecesOf(faces, line)));
  return pieces;
}
function flat(points: readonly Point[]): Places {
  const places = new Float64Array(2 * points.length);
  points.forEach((point, i) => places.set(point, 2 * i));
  return places;
}

// Whether a box about some line meets the scene's data.
export function isWithin(terrain: Terrain, of_features: readonly Laid[]): boolean {
  return of_features.some(({ outline }) => outline.some((part) => terrain.scene.samples.every((count, axis) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = axis; i < part.length; i += 2) [low, high] = [Math.min(low, part[i]!), Math.max(high, part[i]!)];
    return low < count && high >= 0;
  })));
}
