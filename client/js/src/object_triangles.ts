// The triangles of a scene's objects, of the newest mesh that has come, for rays. Objects are numbered in the order of the scene file.
import type { ChannelUpdate, MeshUpdate } from './core/mesh_update.js';
import type { Vector } from './scene.js';

/** @internal */
export interface ObjectHit {
  distance: number;
  object: number;
  model: number;
}

/** @internal */
export class ObjectTriangles {
  private positions = new Float32Array(); // four numbers a vertex, from the origin
  private indices = new Uint32Array();
  private parts: Uint32Array = new Uint32Array(); // first index, number of indices and model of each object
  private origin: readonly number[] = [0, 0, 0];

  /** Takes what changes from the update before. */
  add({ objects: { channels }, object_parts, origin }: MeshUpdate): void {
    this.positions = changed(this.positions, channels.to_position);
    this.indices = changed(this.indices, channels.index);
    [this.parts, this.origin] = [object_parts, origin];
  }
  clear(): void {
    [this.positions, this.indices, this.parts] = [new Float32Array(), new Uint32Array(), new Uint32Array()];
  }

  /** The nearest triangle that a ray meets, from either side; `direction` is of length 1. */
  raycast(origin: readonly number[], direction: readonly number[], far: number): ObjectHit | null {
    const from = origin.map((v, i) => v - this.origin[i]!);
    let nearest: ObjectHit | null = null;
    for (let part = 0; part < this.parts.length; part += 3) {
      const [first, count, model] = this.parts.subarray(part, part + 3) as unknown as [number, number, number];
      for (let at = first; at < first + count; at += 3) {
        const distance = this.distanceTo(at, from, direction);
        if (distance < (nearest?.distance ?? Infinity) && distance <= far) nearest = { distance, object: part / 3, model };
      }
    }
    return nearest;
  }

  // Of Möller and Trumbore; infinite if the ray goes by.
  private distanceTo(at: number, from: readonly number[], d: readonly number[]): number {
    const { positions: p, indices } = this;
    const [a, b, c] = [4 * indices[at]!, 4 * indices[at + 1]!, 4 * indices[at + 2]!];
    const [e1x, e1y, e1z] = [p[b]! - p[a]!, p[b + 1]! - p[a + 1]!, p[b + 2]! - p[a + 2]!];
    const [e2x, e2y, e2z] = [p[c]! - p[a]!, p[c + 1]! - p[a + 1]!, p[c + 2]! - p[a + 2]!];
    const [px, py, pz] = [d[1]! * e2z - d[2]! * e2y, d[2]! * e2x - d[0]! * e2z, d[0]! * e2y - d[1]! * e2x];
    const volume = e1x * px + e1y * py + e1z * pz;
    if (volume === 0) return Infinity;
    const [tx, ty, tz] = [from[0]! - p[a]!, from[1]! - p[a + 1]!, from[2]! - p[a + 2]!];
    const u = (tx * px + ty * py + tz * pz) / volume;
    if (u < 0 || u > 1) return Infinity;
    const [qx, qy, qz] = [ty * e1z - tz * e1y, tz * e1x - tx * e1z, tx * e1y - ty * e1x];
    const v = (d[0]! * qx + d[1]! * qy + d[2]! * qz) / volume;
    if (v < 0 || u + v > 1) return Infinity;
    const t = (e2x * qx + e2y * qy + e2z * qz) / volume;
    return t >= 0 ? t : Infinity;
  }
}

function changed<T extends Float32Array | Uint32Array>(held: T, update: ChannelUpdate | undefined): T {
  if (!update) return held;
  let next = held;
  if (held.length !== update.size) {
    next = new (held.constructor as new (size: number) => T)(update.size);
    next.set(held.subarray(0, Math.min(held.length, update.size)));
  }
  let from = 0;
  for (let i = 0; i < update.ranges.length; i += 2) {
    const [begin, end] = [update.ranges[i]!, update.ranges[i + 1]!];
    next.set((update.data as T).subarray(from, from + end - begin), begin);
    from += end - begin;
  }
  return next;
}

/** What a ray meets. */
export interface Hit {
  /** In the scene's axes. */
  readonly point: Vector;
  readonly distance: number;
  /** Which object of the scene it is, in the order of the scene file; null: the ground. */
  readonly object: number | null;
  /** Which of the scene's models the object has; null: the ground. */
  readonly model: number | null;
}
