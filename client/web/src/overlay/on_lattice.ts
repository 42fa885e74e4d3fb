// Features on a scene's lattice, where the ground is shaded.
import type { MapPoint, Terrain } from '@foreland/client';
import type { Feature, Places } from './feature';

export function mapPointsOf(terrain: Terrain, places: Places): MapPoint[] {
  const is_geographic = terrain.scene.frame !== 'planar';
  return Array.from({ length: places.length / 2 }, (_, i) => {
    const [x, y] = [places[2 * i]!, places[2 * i + 1]!];
    return is_geographic ? { lon: x, lat: y } : { easting: x, northing: y };
  });
}

export function latticeOf(terrain: Terrain, place: MapPoint): readonly [number, number] {
  return terrain.place(terrain.toScene({ ...place, height: 0 }))!.lattice;
}

// The parts of each feature. A generator, for slices (slices.ts).
export function* onLattice(terrain: Terrain, features: readonly Feature[]): Generator<void, Places[][]> {
  const of_features: Places[][] = [];
  for (const { parts } of features) {
    const of_parts: Places[] = [];
    for (const part of parts) {
      const places = new Float64Array(part.length);
      for (const [i, place] of mapPointsOf(terrain, part).entries()) {
        places.set(latticeOf(terrain, place), 2 * i);
        if (i % 128 === 127) yield;
      }
      of_parts.push(places);
      yield;
    }
    of_features.push(of_parts);
  }
  return of_features;
}

// Whether a box about some part meets the scene's data.
export function isWithin(terrain: Terrain, of_features: readonly (readonly Places[])[]): boolean {
  return of_features.some((parts) => parts.some((part) => terrain.scene.samples.every((count, axis) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = axis; i < part.length; i += 2) [low, high] = [Math.min(low, part[i]!), Math.max(high, part[i]!)];
    return low < count && high >= 0;
  })));
}
