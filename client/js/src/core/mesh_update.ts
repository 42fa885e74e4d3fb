// What changes in the mesh from one version to the next, in one block of memory that can be handed to another thread.
import type { Changes, Content, Mesh, ObjectArrays, Pose, Region } from './values.js';
import { tileMemoryOf, type TileUpdate } from './tile_update.js';

// The order of a part's channels. `line` is there only where edges are to be drawn, `from_moved` and `to_moved` where ground moves,
// `from_bend` and `to_bend` where vertices move on curves.
export const kChannels = ['from_position', 'to_position', 'from_moved', 'to_moved', 'from_bend', 'to_bend', 'from_normal', 'to_normal', 'texture_coordinate', 'index', 'line'] as const;
export type ChannelName = (typeof kChannels)[number];

export type Elements = Float32Array<ArrayBuffer> | Int8Array<ArrayBuffer> | Uint32Array<ArrayBuffer>;

// Elements that change in an array: `data` has those of the first range, then those of the second, and so on. Ranges are pairs of
// positions in the array: the first number that changes, and one past the last.
export interface ChannelUpdate {
  size: number; // of the array, in numbers
  ranges: Uint32Array;
  data: Elements;
}

// Of the terrain or of all objects.
export interface PartUpdate {
  is_whole: boolean; // it needs nothing of the version before
  triangles: number;
  channels: Partial<Record<ChannelName, ChannelUpdate>>;
}

export type PartLines = ChannelUpdate;

export interface MeshUpdate {
  version: number; // follows that of the update before it
  oldest_version: number; // that may still be shown
  interval: Uint8Array; // for Screen.add
  origin: [number, number, number];
  to_nodes: number;
  changed_nodes: number; // added or removed since the session began, up to the keyframe that it ends with
  to_pose: Pose;
  to_region: Region; // of the keyframe at to_time_ms
  to_time_ms: number;
  terrain: PartUpdate;
  objects: PartUpdate;
  object_parts: Uint32Array; // as ObjectArrays.parts
  tiles: Record<Content, TileUpdate | null>;
}

const kItems = { from_position: 4, to_position: 4, from_moved: 1, to_moved: 1, from_bend: 3, to_bend: 3, from_normal: 4, to_normal: 4, texture_coordinate: 2, index: 3 } as const;

type Source = Partial<Record<Exclude<ChannelName, 'line'>, { data: Float32Array | Int8Array | Uint32Array; ranges: Uint32Array }>>;
type TerrainArrays = Pick<Mesh, 'from_moved' | 'to_moved' | 'from_bends' | 'to_bends'>; // of the terrain; moved changes where positions do

function sourceOf(arrays: Omit<ObjectArrays, 'parts'>, changes: Changes, terrain: TerrainArrays | null): Source {
  return {
    ...(terrain && terrain.to_moved.length > 0 ? {
      from_moved: { data: terrain.from_moved, ranges: changes.from_positions },
      to_moved: { data: terrain.to_moved, ranges: changes.to_positions },
    } : {}),
    ...(terrain && terrain.to_bends.length > 0 ? {
      from_bend: { data: terrain.from_bends, ranges: changes.bends },
      to_bend: { data: terrain.to_bends, ranges: changes.bends },
    } : {}),
    from_position: { data: arrays.from_positions, ranges: changes.from_positions },
    to_position: { data: arrays.to_positions, ranges: changes.to_positions },
    from_normal: { data: arrays.from_normals, ranges: changes.from_normals },
    to_normal: { data: arrays.to_normals, ranges: changes.to_normals },
    texture_coordinate: { data: arrays.texture_coordinates, ranges: changes.texture_coordinates },
    index: { data: arrays.indices, ranges: changes.triangles },
  };
}

function partOf(source: Source, triangles: number, is_whole: boolean, lines: PartLines | null): PartUpdate {
  const channels: PartUpdate['channels'] = {};
  for (const name of Object.keys(source) as (keyof Source)[]) {
    const from = source[name]!;
    channels[name] = channelOf(from.data, is_whole ? null : from.ranges, kItems[name]);
  }
  if (lines) channels.line = lines;
  return { is_whole, triangles, channels };
}

// Copies the ranges, which are of elements of `items` numbers; all if there are none.
function channelOf(data: Float32Array | Int8Array | Uint32Array, elements: Uint32Array | null, items: number): ChannelUpdate {
  const ranges = elements ? elements.map((at) => items * at) : Uint32Array.of(0, data.length);
  let count = 0;
  for (let i = 0; i < ranges.length; i += 2) count += ranges[i + 1]! - ranges[i]!;
  const copy = new (data.constructor as { new (n: number): Elements })(count);
  let at = 0;
  for (let i = 0; i < ranges.length; i += 2) {
    copy.set(data.subarray(ranges[i], ranges[i + 1]), at);
    at += ranges[i + 1]! - ranges[i]!;
  }
  return { size: data.length, ranges, data: copy };
}

// `last_version` is that of the update before.
export function updateOf(mesh: Mesh, changes: { terrain: Changes; objects: Changes }, interval: Uint8Array, last_version: number,
                         wants_lines: boolean, tiles: MeshUpdate['tiles'], changed_nodes: number): MeshUpdate {
  const isWhole = (part: Changes) => part.base_version === 0 || part.base_version !== last_version;
  const { version, oldest_version, origin, to_nodes, to_pose, to_region, to_time_ms, objects } = mesh;
  const lines = linesOf(mesh, wants_lines);
  return {
    version, oldest_version, interval, origin, to_nodes, changed_nodes, to_pose, to_region, to_time_ms,
    terrain: partOf(sourceOf(mesh, changes.terrain, mesh), mesh.triangles, isWhole(changes.terrain), lines?.terrain ?? null),
    objects: partOf(sourceOf(objects, changes.objects, null), trianglesOf(objects.parts), isWhole(changes.objects), lines?.objects ?? null),
    object_parts: objects.parts.slice(),
    tiles,
  };
}

// Those that are drawn: others have three times the same corner.
function trianglesOf(parts: Uint32Array): number {
  let indices = 0;
  for (let i = 1; i < parts.length; i += 3) indices += parts[i]!;
  return indices / 3;
}

// What is to be handed over, and not copied, with an update.
export function memoryOf(update: MeshUpdate): Transferable[] {
  const arrays = [update.terrain, update.objects].flatMap((part) => Object.values(part.channels).map((channel) => channel.data.buffer));
  return [...arrays, ...Object.values(update.tiles).flatMap((tiles) => (tiles ? tileMemoryOf(tiles) : []))];
}

export function linesOf(mesh: Mesh, wants_lines: true): { terrain: PartLines; objects: PartLines };
export function linesOf(mesh: Mesh, wants_lines: boolean): { terrain: PartLines; objects: PartLines } | null;
export function linesOf(mesh: Mesh, wants_lines: boolean): { terrain: PartLines; objects: PartLines } | null {
  if (!wants_lines) return null;
  return { terrain: channelOf(edgesOf(mesh.indices, false), null, 1), objects: channelOf(edgesOf(mesh.objects.indices, true), null, 1) };
}

// Each inner edge is in two triangles, in opposite directions: it is drawn by the one in which it rises. With seams triangles that
// share an edge may name its ends differently.
function edgesOf(indices: Uint32Array, has_seams: boolean): Uint32Array {
  const lines = new Uint32Array(2 * indices.length);
  let count = 0;
  for (let i = 0; i < indices.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = indices[i + k]!;
      const b = indices[i + ((k + 1) % 3)]!;
      if (a > b && !has_seams) continue;
      lines[count++] = a;
      lines[count++] = b;
    }
  }
  return lines.subarray(0, count);
}
