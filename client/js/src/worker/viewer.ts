// A viewer in the client core: the client's side of a session.
import { type Core, welcomeAt } from '../core/core.js';
import type { ExactGround } from '../core/messages.js';
import {
  readChangesRecord, readFrameRecord, readGroundRecord, readImageRecord, readStatisticsRecord, readTextRecord, readTilesRecord, type FrameRecord,
  writeRequestRecord,
} from '../core/records.js';
import {
  kBlends, kContents, kPredictors, kStrategies, kTileSide, type Blend, type Changes, type Content, type Frame, type Mesh, type Pose,
  type Request, type Statistics, type TextureLayers, type TileSelection, type Welcome,
} from '../core/values.js';

const kNoLayer = 0xffffffff;

// The client's side of a session.
export class Viewer {
  readonly handle: number; // of the module
  private frame_record = 0;

  constructor(private readonly core: Core, request: Request) {
    core.put(recordOf(request));
    this.handle = core.exports.foreland_create();
  }

  // Continues over a new connection after the old one was lost: resumes from the sections held, if the scene is the same.
  reconnect(now_ms: number): void {
    this.core.exports.foreland_reconnect(this.handle, now_ms);
  }

  destroy(): void {
    this.core.exports.foreland_destroy(this.handle);
  }
  // Null, or why the message was refused.
  receive(message: Uint8Array, now_ms: number): string | null {
    this.core.put(message);
    if (this.core.exports.foreland_receive(this.handle, now_ms) === 1) return null;
    return this.core.textAt(this.core.exports.foreland_error(this.handle));
  }
  takeOutgoing(): Uint8Array<ArrayBuffer> | null {
    const record = this.core.exports.foreland_take_outgoing(this.handle);
    if (record === 0) return null;
    const { text, size } = readTextRecord(this.core.view(), record);
    return this.core.copy(text, size);
  }
  setRequest(request: Request): void {
    this.core.put(recordOf(request));
    this.core.exports.foreland_set_request(this.handle);
  }

  // Takes effect with the next keyframe. Nodes in transition continue from the weights that they have.
  setBlend(blend: Blend): void {
    this.core.exports.foreland_set_blend(this.handle, kBlends.indexOf(blend));
  }

  // From now on scene time, in milliseconds since 1970, goes from `scene_ms` at `rate` scene seconds a second.
  setSceneClock(now_ms: number, scene_ms: number, rate: number): void {
    this.core.exports.foreland_set_scene_clock(this.handle, now_ms, scene_ms, rate);
  }

  // The camera of the next frame is jumped to, which the server is told.
  jump(): void {
    this.core.exports.foreland_jump(this.handle);
  }
  frame(now_ms: number, pose: Pose): Frame {
    this.frame_record = this.core.exports.foreland_frame(this.handle, now_ms, ...pose.eye, ...pose.orientation);
    const r = readFrameRecord(this.core.view(), this.frame_record);
    const { shown_time_ms, scene_time_ms, weight, mesh_version, tau_px } = r;
    return { pose: r.pose, shown_time_ms, scene_time_ms, weight, mesh_version, tau_px };
  }
  // The mesh of the last frame().
  mesh(): Mesh {
    const view = this.core.view();
    return meshOf(view.buffer as ArrayBuffer, readFrameRecord(view, this.frame_record));
  }

  // From now on meshes are taken by takeNewest(), as soon as they are made, instead of when they are shown.
  drawAhead(): void {
    this.core.exports.foreland_draw_ahead(this.handle);
  }

  // What was taken is lost: the newest mesh is taken again, and all tiles come again.
  redraw(): void {
    this.core.exports.foreland_redraw(this.handle);
  }

  // The newest mesh, or false if it has been taken already; mesh() gives it.
  takeNewest(): boolean {
    const record = this.core.exports.foreland_take_newest(this.handle);
    if (record !== 0) this.frame_record = record;
    return record !== 0;
  }

  // The newest mesh's interval, for Screen.add; a copy.
  interval(): Uint8Array<ArrayBuffer> {
    const record = this.core.exports.foreland_interval(this.handle);
    const { text, size } = readTextRecord(this.core.view(), record);
    return this.core.copy(text, size);
  }

  // What is news about the ground `reach` samples about an eye, for Screen.setGround; a copy. Null before the welcome.
  ground(eye: readonly number[], reach: number): Uint8Array<ArrayBuffer> | null {
    const record = this.core.exports.foreland_ground(this.handle, eye[0]!, eye[1]!, eye[2]!, reach);
    if (record === 0) return null;
    const { text, size } = readTextRecord(this.core.view(), record);
    return this.core.copy(text, size);
  }

  // What has changed in the last mesh since the last call. Valid as long as the mesh; to be called before mesh(), whose arrays it
  // makes invalid.
  takeChanges(): { terrain: Changes; objects: Changes } {
    const [terrain, objects] = [0, 1].map((part) => this.core.exports.foreland_take_changes(this.handle, part)) as [number, number];
    return { terrain: this.changesAt(terrain), objects: this.changesAt(objects) };
  }
  private changesAt(record: number): Changes {
    const view = this.core.view();
    const r = readChangesRecord(view, record);
    const ranges = (address: number, count: number) => new Uint32Array(view.buffer as ArrayBuffer, address, 2 * count);
    return {
      base_version: r.base_version,
      from_positions: ranges(r.from_positions, r.from_position_ranges),
      to_positions: ranges(r.to_positions, r.to_position_ranges),
      bends: ranges(r.bends, r.bend_ranges),
      from_normals: ranges(r.from_normals, r.from_normal_ranges),
      to_normals: ranges(r.to_normals, r.to_normal_ranges),
      texture_coordinates: ranges(r.texture_coordinates, r.texture_coordinate_ranges),
      triangles: ranges(r.triangles, r.triangle_ranges),
    };
  }

  // How many tiles the graphics card holds. To be told before the first mesh is taken.
  setTextureLayers(layers: TextureLayers): void {
    this.core.exports.foreland_set_texture_layers(this.handle, layers.relief, layers.imagery);
  }

  // What of the tiles is drawn with the mesh that takeNewest() gave; null if the scene has none. A copy.
  tiles(content: Content): TileSelection | null {
    const record = this.core.exports.foreland_tiles(this.handle, kContents.indexOf(content));
    if (record === 0) return null;
    const view = this.core.view();
    const r = readTilesRecord(view, record);
    const arrivals = new Uint32Array(view.buffer as ArrayBuffer, r.arrivals, 5 * r.arrival_count);
    const dropped = new Uint32Array(view.buffer as ArrayBuffer, r.dropped, 2 * r.dropped_count);
    return {
      scene: r.scene,
      shown: r.shown,
      page_table: new Uint16Array(view.buffer as ArrayBuffer, r.page_table, 4 * r.page_count).slice(),
      arrivals: Array.from({ length: r.arrival_count }, (_, i) => {
        const [low, high, layer, parent, relit] = arrivals.subarray(5 * i) as unknown as [number, number, number, number, number];
        return { key: [low, high], layer, parent_layer: parent === kNoLayer ? null : parent, is_relit: relit === 1 };
      }),
      dropped: Array.from({ length: r.dropped_count }, (_, i) => [dropped[2 * i]!, dropped[2 * i + 1]!]),
    };
  }
  // Slopes of a tile of relief that arrives, as pairs of half floats, or of its half-size image. A copy.
  slopes([low, high]: readonly [number, number], is_half: boolean): Uint16Array<ArrayBuffer> {
    const side = is_half ? kTileSide / 2 : kTileSide;
    const address = this.core.exports.foreland_slopes(this.handle, low, high, is_half ? 1 : 0);
    return new Uint16Array(this.core.view().buffer as ArrayBuffer, address, 2 * side * side).slice();
  }
  // Ground texels of a tile of relief that arrives or is relit (client/imagery/shadows.h), or of its half-size image. A copy.
  groundTexels([low, high]: readonly [number, number], is_half: boolean): Uint8Array<ArrayBuffer> {
    const side = is_half ? kTileSide / 2 : kTileSide;
    const address = this.core.exports.foreland_ground_texels(this.handle, low, high, is_half ? 1 : 0);
    return this.core.copy(address, 4 * side * side);
  }
  // Towards the sun that casts shadows; null: none does.
  setSun(sun: readonly number[] | null): void {
    const [x, y, z] = sun ?? [0, 0, 1];
    this.core.exports.foreland_set_sun(this.handle, x!, y!, z!, sun ? 1 : 0);
  }
  // Decodes a tile of relief; false if none is wanted.
  decodeRelief(): boolean {
    return this.core.exports.foreland_decode_relief(this.handle) === 1;
  }
  // An image to be decoded, and then told of; each once. Null if there is none.
  nextImage(): { key: readonly [number, number]; coded: Uint8Array<ArrayBuffer> } | null {
    const record = this.core.exports.foreland_next_image(this.handle);
    if (record === 0) return null;
    const r = readImageRecord(this.core.view(), record);
    return { key: r.key, coded: this.core.copy(r.coded, r.size) };
  }
  imageReady([low, high]: readonly [number, number]): void {
    this.core.exports.foreland_image_ready(this.handle, low, high);
  }

  requestTour(name: string, seconds: number): void {
    this.core.put(new TextEncoder().encode(name));
    this.core.exports.foreland_request_tour(this.handle, seconds);
  }
  // Whether a tour has arrived since the last call.
  takeTour(): boolean {
    return this.core.exports.foreland_take_tour(this.handle) > 0;
  }
  startTour(start_ms: number): void {
    this.core.exports.foreland_start_tour(this.handle, start_ms);
  }

  // At lattice positions, x and y each. Gives the id that the reply will have.
  requestGround(positions: Float64Array): number {
    this.core.put(new Uint8Array(positions.buffer, positions.byteOffset, positions.byteLength));
    return this.core.exports.foreland_request_ground(this.handle);
  }
  // The reply to that request, once; a copy.
  takeGround(request: number): { id: number; ground: ExactGround } | null {
    const record = this.core.exports.foreland_take_ground(this.handle, request);
    if (record === 0) return null;
    const { id, count, heights_m, undulations_m } = readGroundRecord(this.core.view(), record);
    const floats = (at: number) => new Float32Array(this.core.copy(at, 4 * count).buffer);
    return { id, ground: { heights_m: floats(heights_m), undulations_m: undulations_m === 0 ? null : floats(undulations_m) } };
  }
  // The shortest message that changes nothing: it takes back a request that there is not.
  saySomething(): void {
    this.core.exports.foreland_cancel_request(this.handle, 0);
  }
  // Poses of seven numbers each: eye, orientation. False if that is no path.
  announcePath(poses: Float64Array, start_ms: number, step_ms: number): boolean {
    this.core.put(new Uint8Array(poses.buffer, poses.byteOffset, poses.byteLength));
    return this.core.exports.foreland_announce_path(this.handle, start_ms, step_ms) === 1;
  }

  welcome(): Welcome | null {
    const at = this.core.exports.foreland_welcome(this.handle);
    return at === 0 ? null : welcomeAt(this.core, at);
  }
  isGreeted(): boolean {
    return this.core.exports.foreland_welcome(this.handle) !== 0;
  }
  // The area of a large scene that the camera is in, for the address of the next connection; null: none.
  area(): number | null {
    const area = this.core.exports.foreland_area(this.handle);
    return area < 0 ? null : area;
  }
  statistics(): Statistics {
    const record = this.core.exports.foreland_statistics(this.handle);
    return readStatisticsRecord(this.core.view(), record);
  }
}

function meshOf(memory: ArrayBuffer, r: FrameRecord): Mesh {
  const [vertices, object_vertices] = [r.vertex_count, r.object_vertex_count];
  return {
    version: r.mesh_version,
    oldest_version: r.oldest_version,
    origin: r.origin,
    vertices,
    triangles: r.index_count / 3,
    to_time_ms: r.to_time_ms,
    to_pose: r.to_pose,
    texture_coordinates: new Float32Array(memory, r.lattice_positions, 2 * vertices),
    from_positions: new Float32Array(memory, r.from_positions, 4 * vertices),
    to_positions: new Float32Array(memory, r.to_positions, 4 * vertices),
    from_moved: new Float32Array(memory, r.from_moved, r.from_moved > 0 ? vertices : 0),
    to_moved: new Float32Array(memory, r.to_moved, r.to_moved > 0 ? vertices : 0),
    from_bends: new Float32Array(memory, r.from_bends, r.from_bends > 0 ? 3 * vertices : 0),
    to_bends: new Float32Array(memory, r.to_bends, r.to_bends > 0 ? 3 * vertices : 0),
    from_normals: new Int8Array(memory, r.from_normals, 4 * vertices),
    to_normals: new Int8Array(memory, r.to_normals, 4 * vertices),
    indices: new Uint32Array(memory, r.indices, r.index_count),
    to_nodes: r.to_nodes,
    to_region: { radius_m: r.to_region_radius_m, angle_rad: r.to_region_angle_rad },
    objects: {
      vertices: object_vertices,
      from_positions: new Float32Array(memory, r.object_from_positions, 4 * object_vertices),
      to_positions: new Float32Array(memory, r.object_to_positions, 4 * object_vertices),
      from_normals: new Int8Array(memory, r.object_from_normals, 4 * object_vertices),
      to_normals: new Int8Array(memory, r.object_to_normals, 4 * object_vertices),
      texture_coordinates: new Float32Array(memory, r.object_texture_coordinates, 2 * object_vertices),
      indices: new Uint32Array(memory, r.object_indices, r.object_index_count),
      parts: new Uint32Array(memory, r.object_parts, 3 * r.object_part_count),
    },
  };
}

function recordOf(r: Request): Uint8Array {
  const { strategy, predictor, occlusion, relief, imagery, longest_keyframe_ms = 0, max_triangles = 0, max_bytes_per_second = 0, eye_radius_m = 0 } = r;
  return writeRequestRecord({
    ...r, longest_keyframe_ms, max_triangles, max_bytes_per_second, eye_radius_m, occlusion: Number(occlusion), relief: Number(relief), imagery: Number(imagery),
    strategy: kStrategies.indexOf(strategy), predictor: kPredictors.indexOf(predictor),
  });
}
