// Which way is up, east and north at a point of a scene.
import type { Scene, Vector } from '@foreland/client';

export type UpAt = (point: Readonly<Vector>) => Vector;

const kEquator_m = 6_378_137, kPole_m = 6_356_752.314;

// Away from the ellipsoid; within 2e-5 of what `Terrain.place` tells, for points up to 20 km high, and without asking it.
export function upIn({ toEcef: m }: Pick<Scene, 'toEcef'>): UpAt {
  if (!m) return () => [0, 0, 1];
  return (point) => {
    const ecef = [0, 1, 2].map((row) => m[row]! * point[0] + m[4 + row]! * point[1] + m[8 + row]! * point[2] + m[12 + row]!);
    const normal = ecef.map((v, k) => v / (k === 2 ? kPole_m : kEquator_m) ** 2), length = Math.hypot(...normal);
    return [0, 1, 2].map((axis) => normal.reduce((sum, v, row) => sum + (v / length) * m[4 * axis + row]!, 0)) as Vector;
  };
}

export function basisAt(point: Readonly<Vector>, upAt: UpAt): [east: Vector, north: Vector, up: Vector] {
  const up = upAt(point), level: Vector = [-up[1] * up[0], 1 - up[1] * up[1], -up[1] * up[2]];
  const length = Math.hypot(...level), north = level.map((v) => v / length) as Vector;
  return [[north[1] * up[2] - north[2] * up[1], north[2] * up[0] - north[0] * up[2], north[0] * up[1] - north[1] * up[0]], north, up];
}
