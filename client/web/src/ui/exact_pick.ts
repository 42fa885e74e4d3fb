// What a pixel shows, exactly: of the server, on the ground at full resolution and objects, or on the wall of a cut, which what is cut away does
// not hide. Over a globe with a sea that is drawn, its surface; where a globe's server answers no questions of sight, what is drawn.
import type { Terrain, Vector } from '@foreland/client';
import { Vector3 } from 'three';
import { metExactly, wayAlong } from '../cut/rays';
import type { Picture } from '../draw/picture';

// What the straight line through a point of the window meets first; null beyond the ground.
export async function pickExactly(terrain: Terrain, picture: Picture, x: number, y: number, scene_time_ms: number): Promise<Vector | null> {
  const is_globe = terrain.scene.frame === 'globe', { eye } = picture, direction = picture.directionAt(x, y), way = new Vector3(...direction);
  const pointAt = (distance_m: number) => eye.map((v, i) => v + distance_m * direction[i]!) as Vector;
  const sea_m = is_globe ? picture.sea.distanceAlong(way) : null;
  const drawn = () => {
    const distance_m = picture.groundDistance(new Vector3(...eye), way);
    return distance_m === null ? null : { point: pointAt(distance_m) };
  };
  const [met] = await metExactly(terrain, picture.cut_view.shown, [wayAlong(terrain, eye, direction)], scene_time_ms)
    .catch((error: unknown) => { if (is_globe) return [drawn()]; throw error; });
  if (sea_m === null || (met && Math.hypot(...met.point.map((v, i) => v - eye[i]!)) < sea_m)) return met?.point ?? null;
  return pointAt(sea_m);
}
