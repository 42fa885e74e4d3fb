// What a pixel shows, exactly: of the server, on the ground at full resolution and objects. Over a globe what is drawn there, for a line of sight
// from space is longer than any that a server looks along.
import type { Terrain, Vector } from '@foreland/client';
import type { Picture } from '../draw/picture';

// What the straight line through a point of the window meets first; null beyond the ground.
export async function pickExactly(terrain: Terrain, picture: Picture, x: number, y: number, scene_time_ms: number): Promise<Vector | null> {
  const { bounds: { low, high }, frame } = terrain.scene;
  if (frame === 'globe') return picture.drawnAt(x, y)?.toArray() ?? null;
  const far_m = 2 * Math.hypot(high[0] - low[0], high[1] - low[1]);
  const way = picture.directionAt(x, y);
  const there = picture.eye.map((v, i) => v + far_m * way[i]!) as Vector;
  const ends = [terrain.place(picture.eye)!, terrain.place(there)!] as const;
  return (await terrain.visible([ends], { refraction: frame === 'planar' ? 1 : 0, sceneTime: scene_time_ms }))[0]!.hit;
}
