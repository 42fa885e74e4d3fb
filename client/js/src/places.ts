// Where things are in a scene: places of its map or of the earth, heights of the ground that is held, and what rays meet.
import type { Screen } from './core/screen.js';
import type { Welcome } from './core/values.js';
import { ForelandError } from './errors.js';
import type { Hit, ObjectTriangles } from './object_triangles.js';
import { placeOf, type MapPoint, type Place, type Scene, type Vector } from './scene.js';

/** @internal Of a terrain whose session has begun. */
export class Places {
  constructor(private readonly screen: Screen, private readonly welcome: Welcome, private readonly scene: Scene) {}

  // Null if the client core does not know the scene yet.
  at(point: readonly number[]): Place | null {
    const at = this.screen.mapPosition(point);
    return at && placeOf(at, this.welcome.frame, this.welcome.zero_surface);
  }
  toScene(place: MapPoint): Vector | null {
    const is_geographic = this.scene.frame !== 'planar';
    if ('lon' in place !== is_geographic) throw new ForelandError('argument', is_geographic ? 'The scene is on the earth: name places by lon and lat.'
      : `The scene is on a map (${this.scene.crs}): name places by easting and northing.`);
    const across = 'lon' in place ? [place.lat, place.lon] as const : [place.northing, place.easting] as const;
    return this.screen.scenePoint(across, place.height ?? 0);
  }
  latticeOf(place: MapPoint): [number, number] {
    return this.screen.mapPosition(this.toScene(place)!)!.lattice;
  }
  groundOnRay(origin: readonly number[], direction: readonly number[], far: number): Vector | null {
    return this.screen.ray(origin, direction, far);
  }
  pick(objects: ObjectTriangles, origin: readonly number[], direction: readonly number[], far: number): Hit | null {
    const length = Math.hypot(...direction), unit = direction.map((v) => v / length);
    if (!(length > 0)) return null;
    const met = objects.raycast(origin, unit, far);
    const ground = this.groundOnRay(origin, direction, met?.distance ?? far);
    if (ground) return { point: ground, distance: Math.hypot(...ground.map((v, i) => v - origin[i]!)), object: null, model: null };
    return met && { ...met, point: unit.map((v, i) => origin[i]! + met.distance * v) as Vector };
  }
}
