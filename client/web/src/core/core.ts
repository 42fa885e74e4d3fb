// The client core (client/wasm) as the page sees it: a module to compile once, with an instance for each thread. The worker has a
// Viewer for each session, the drawing thread a Screen. Arrays point into the instance's memory and are valid until the next call into it.
import {
  kRecordLayout, readChangesRecord, readFrameRecord, readImageRecord, readLayerRecord, readMapPositionRecord, readPoseRecord, readScreenRecord,
  readSlopeFrameRecord, readStatisticsRecord, readTextRecord, readTilesRecord, readWelcomeRecord, type FrameRecord, type LayerRecord,
  type MapPositionRecord, type PoseRecord, type SlopeFrameRecord, type StatisticsRecord,
} from './records';

export type Pose = PoseRecord; // eye: scene frame, metres; orientation: x, y, z, w

export const kStrategies = ['delay', 'current', 'predict'] as const;
export const kPredictors = ['hold', 'velocity', 'acceleration', 'path', 'double-exponential', 'kalman'] as const;
export const kBlends = ['keyframe', 'geomorph'] as const; // client/mesh/blend.h
export type Strategy = (typeof kStrategies)[number];
export type Predictor = (typeof kPredictors)[number];
export type Blend = (typeof kBlends)[number];

export interface Request {
  fov_rad: number;
  width_px: number;
  height_px: number;
  tau_px: number;
  strategy: Strategy;
  predictor: Predictor;
  keyframe_ms: number;
  longest_keyframe_ms?: number; // of adaptive keyframes, of which keyframe_ms is the shortest; 0 or absent: they are fixed
  occlusion: boolean; // leave out what ridges hide, if the server can; a connection's first request decides whether later ones may
  memory_bytes: number; // for terrain that was sent and is not needed now; a connection's first request decides
  relief: boolean; // tiles that ground is shaded by
  imagery: boolean;
  tile_bytes: number; // for coded tiles; a connection's first request decides
}

// What tiles are of, in the order of proto::TileContent; and how many of them the graphics card holds.
export const kContents = ['relief', 'imagery'] as const;
export type Content = (typeof kContents)[number];
export type TextureLayers = Record<Content, number>;

// A tile to be uploaded before a mesh is shown: into which layer of the texture array, and in which its parent is.
export interface TileArrival {
  key: readonly [number, number];
  layer: number;
  parent_layer: number | null;
  is_relit: boolean; // only its shadows have changed; it is drawn already
}

// What of the tiles of a content is drawn with a mesh (client/imagery/residency.h).
export interface TileSelection {
  scene: number; // another one has other tiles
  shown: number;
  page_table: Uint16Array<ArrayBuffer>;
  arrivals: TileArrival[];
  dropped: (readonly [number, number])[];
}

export type Layer = Pick<LayerRecord, 'origin' | 'texel' | 'size' | 'levels' | 'low_m' | 'code_m'> & { attribution: string };
export type SlopeFrame = SlopeFrameRecord;

export interface Mesh {
  version: number;
  oldest_version: number; // of meshes that may still be shown
  origin: [number, number, number];
  vertices: number;
  triangles: number;
  from_nodes: number;
  to_nodes: number;
  to_index: number;
  to_time_ms: number;
  to_pose: Pose;
  texture_coordinates: Float32Array; // positions on the lattice
  from_positions: Float32Array;
  to_positions: Float32Array;
  from_moved: Float32Array; // metres upwards since the first epoch; empty if the ground does not move
  to_moved: Float32Array;
  from_normals: Int8Array;
  to_normals: Int8Array;
  indices: Uint32Array;
  objects: ObjectArrays;
}

// The same arrays for all objects. `parts` has three numbers for each object: first index, number of indices, model.
export interface ObjectArrays {
  vertices: number;
  from_positions: Float32Array;
  to_positions: Float32Array;
  from_normals: Int8Array;
  to_normals: Int8Array;
  texture_coordinates: Float32Array; // u, v in the model's image
  indices: Uint32Array;
  parts: Uint32Array;
}

// What has changed in a mesh's arrays since they were of version `base_version`; 0: all of it. Ranges are pairs: the first
// element, and one past the last; of triangles their numbers.
export interface Changes {
  base_version: number;
  from_positions: Uint32Array;
  to_positions: Uint32Array;
  from_normals: Uint32Array;
  to_normals: Uint32Array;
  texture_coordinates: Uint32Array;
  triangles: Uint32Array;
}

export interface Frame {
  pose: Pose;
  shown_time_ms: number; // the page's clock: the time whose view is shown
  scene_time_ms: number; // since 1970: the time whose ground is shown, in scenes that change in time
  weight: number;
  mesh_version: number; // 0: no mesh yet
  tau_px: number; // what the error of this frame is guaranteed not to exceed; Infinity: nothing is guaranteed
}

// A frame, and the mesh that comes next.
export interface ScreenFrame extends Frame {
  to_time_ms: number; // of the newer keyframe
  to_pose: Pose; // that it was computed for
  end_ms: number; // when the next mesh begins, unless it is late
  next_version: number; // of the mesh to make ready; 0: none
}

export interface Welcome {
  low: [number, number, number];
  high: [number, number, number];
  lowest_m: number;
  highest_m: number;
  tau_px: number;
  keyframe_ms: number;
  title: string;
  crs: string;
  is_geographic: boolean;
  samples: [number, number];
  model_has_image: boolean[]; // of the objects' models
  epochs_ms: number[]; // since 1970, of a scene that changes in time
  most_moved_m: number; // by which its ground moves at most from the first epoch to another
  landmarks: [number, number, number][];
}

// A point of the scene as client/wasm/records.h has it; null where the ground is not known.
export type MapPosition = Omit<MapPositionRecord, 'ground_m' | 'slope_rad'> & { ground_m: number | null; slope_rad: number | null };
export type Statistics = StatisticsRecord;

const kNoLayer = 0xffffffff;
export const kTileSide = 256; // texels; proto/imagery/tile.h

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  foreland_record_layout(): number;
  foreland_buffer(size: number): number;
  foreland_create(fov: number, w: number, h: number, tau: number, strategy: number, predictor: number, interval_ms: number,
                  longest_interval_ms: number, occlusion: number, memory_bytes: number, relief: number, imagery: number, tile_bytes: number): number;
  foreland_destroy(viewer: number): void;
  foreland_reconnect(viewer: number, now_ms: number): void;
  foreland_receive(viewer: number, now_ms: number): number;
  foreland_take_outgoing(viewer: number): number;
  foreland_error(viewer: number): number;
  foreland_frame(viewer: number, now_ms: number, ...pose: number[]): number;
  foreland_draw_ahead(viewer: number): void;
  foreland_take_newest(viewer: number): number;
  foreland_set_texture_layers(viewer: number, relief: number, imagery: number): void;
  foreland_tiles(viewer: number, content: number): number;
  foreland_slopes(viewer: number, low: number, high: number, half: number): number;
  foreland_ground_texels(viewer: number, low: number, high: number, half: number): number;
  foreland_set_sun(viewer: number, x: number, y: number, z: number, wanted: number): void;
  foreland_decode_relief(viewer: number): number;
  foreland_next_image(viewer: number): number;
  foreland_image_ready(viewer: number, low: number, high: number): void;
  foreland_interval(viewer: number): number;
  foreland_ground(viewer: number, x: number, y: number, z: number, reach: number): number;
  foreland_take_changes(viewer: number, part: number): number;
  foreland_set_request(viewer: number, fov: number, w: number, h: number, tau: number, strategy: number, predictor: number,
                       interval_ms: number, longest_interval_ms: number, occlusion: number, memory_bytes: number, relief: number, imagery: number, tile_bytes: number): void;
  foreland_set_blend(viewer: number, blend: number): number;
  foreland_set_scene_clock(viewer: number, at_ms: number, scene_ms: number, rate: number): void;
  foreland_request_tour(viewer: number, seconds: number): void;
  foreland_take_tour(viewer: number): number;
  foreland_start_tour(viewer: number, start_ms: number): void;
  foreland_welcome(viewer: number): number;
  foreland_statistics(viewer: number): number;
  foreland_screen_create(): number;
  foreland_screen_add(screen: number, oldest_version: number): void;
  foreland_screen_next(screen: number): number;
  foreland_screen_frame(screen: number, now_ms: number, ...more: number[]): number;
  foreland_screen_welcome(screen: number): number;
  foreland_screen_layer(screen: number, content: number): number;
  foreland_screen_slope_frame(screen: number): number;
  foreland_screen_ground(screen: number): void;
  foreland_screen_sweep(screen: number, ...path: number[]): number;
  foreland_screen_map_position(screen: number, x: number, y: number, z: number): number;
  foreland_screen_tour(screen: number, start_ms: number): number;
  foreland_screen_tour_pose(screen: number, now_ms: number): number;
}

export class Core {
  private constructor(readonly module: WebAssembly.Module, readonly exports: Exports) {}

  static async load(url: string): Promise<Core> {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url}: HTTP ${response.status}`);
    const core = await Core.of(await WebAssembly.compile(await response.arrayBuffer()));
    if (core.textAt(core.exports.foreland_record_layout()) !== kRecordLayout) throw new Error(`${url} and the page are of different versions.`);
    return core;
  }

  // An instance of a module that another thread has loaded.
  static async of(module: WebAssembly.Module): Promise<Core> {
    let memory: WebAssembly.Memory | undefined;
    const instance = await WebAssembly.instantiate(module, wasiImports(module, () => memory!));
    const exports = instance.exports as unknown as Exports;
    memory = exports.memory;
    exports._initialize();
    return new Core(module, exports);
  }

  view(): DataView {
    return new DataView(this.exports.memory.buffer);
  }
  put(bytes: Uint8Array): void {
    const at = this.exports.foreland_buffer(bytes.length);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
  }
  copy(address: number, size: number): Uint8Array<ArrayBuffer> {
    return new Uint8Array(this.exports.memory.buffer.slice(address, address + size) as ArrayBuffer);
  }
  text(address: number, size: number): string {
    return new TextDecoder().decode(this.copy(address, size));
  }
  textAt(record: number): string {
    const { text, size } = readTextRecord(this.view(), record);
    return this.text(text, size);
  }
}

// The system calls that the module imports: its output goes to the console, an exit throws, and all others answer "not supported".
function wasiImports(module: WebAssembly.Module, memory: () => WebAssembly.Memory): WebAssembly.Imports {
  const kNotSupported = 52;
  const imports: WebAssembly.ModuleImports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    if (from === 'wasi_snapshot_preview1') imports[name] = () => kNotSupported;
  }
  imports.proc_exit = (code: number) => {
    throw new Error(`The client core stopped (code ${code}).`);
  };
  imports.fd_write = (_file: number, parts: number, count: number, written: number) => {
    const view = new DataView(memory().buffer);
    let size = 0;
    let text = '';
    for (let i = 0; i < count; ++i) {
      const length = view.getUint32(parts + 8 * i + 4, true);
      text += new TextDecoder().decode(new Uint8Array(view.buffer, view.getUint32(parts + 8 * i, true), length));
      size += length;
    }
    view.setUint32(written, size, true);
    console.error(text.trimEnd());
    return 0;
  };
  return { wasi_snapshot_preview1: imports };
}

// The client's side of a session.
export class Viewer {
  private readonly handle: number;
  private frame_record = 0;

  constructor(private readonly core: Core, request: Request) {
    this.handle = core.exports.foreland_create(...requestArguments(request));
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
    this.core.exports.foreland_set_request(this.handle, ...requestArguments(request));
  }

  // Takes effect with the next keyframe. Nodes in transition continue from the weights that they have.
  setBlend(blend: Blend): void {
    this.core.exports.foreland_set_blend(this.handle, kBlends.indexOf(blend));
  }

  // From now on scene time, in milliseconds since 1970, goes from `scene_ms` at `rate` scene seconds a second.
  setSceneClock(now_ms: number, scene_ms: number, rate: number): void {
    this.core.exports.foreland_set_scene_clock(this.handle, now_ms, scene_ms, rate);
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

  welcome(): Welcome | null {
    const at = this.core.exports.foreland_welcome(this.handle);
    return at === 0 ? null : welcomeAt(this.core, at);
  }
  isGreeted(): boolean {
    return this.core.exports.foreland_welcome(this.handle) !== 0;
  }
  statistics(): Statistics {
    const record = this.core.exports.foreland_statistics(this.handle);
    return readStatisticsRecord(this.core.view(), record);
  }
}

// What the drawing thread computes itself for each frame, by intervals, welcome, ground and tour that come from the worker.
export class Screen {
  private readonly handle: number;
  constructor(private readonly core: Core) {
    this.handle = core.exports.foreland_screen_create();
  }

  // The interval of a mesh, by Viewer.interval(); meshes before `oldest_version` will not be shown any more.
  add(interval: Uint8Array, oldest_version: number): void {
    this.core.put(interval);
    this.core.exports.foreland_screen_add(this.handle, oldest_version);
  }
  // The version to make ready next; 0: none.
  next(): number {
    return this.core.exports.foreland_screen_next(this.handle);
  }
  // If the mesh of version `ready` can be shown, and the one that was shown last. A mesh whose time has come before it is ready
  // begins when it is; `coming` is being made ready.
  frame(now_ms: number, pose: Pose, strategy: Strategy, ready: number, coming: number): ScreenFrame {
    const more = [...pose.eye, ...pose.orientation, kStrategies.indexOf(strategy), ready, coming];
    const record = this.core.exports.foreland_screen_frame(this.handle, now_ms, ...more); // which may move the memory
    return readScreenRecord(this.core.view(), record);
  }
  // Enters the scene of the server's welcome.
  enter(message: Uint8Array): Welcome {
    this.core.put(message);
    return welcomeAt(this.core, this.core.exports.foreland_screen_welcome(this.handle));
  }
  // The scene's layer of tiles; null if it has none.
  layer(content: Content): Layer | null {
    const at = this.core.exports.foreland_screen_layer(this.handle, kContents.indexOf(content));
    if (at === 0) return null;
    const { origin, texel, size, levels, attribution, attribution_size, low_m, code_m } = readLayerRecord(this.core.view(), at);
    return { origin, texel, size, levels, low_m, code_m, attribution: this.core.text(attribution, attribution_size) };
  }
  // How slopes become normals; null before the welcome.
  slopeFrame(): SlopeFrame | null {
    const at = this.core.exports.foreland_screen_slope_frame(this.handle);
    return at === 0 ? null : readSlopeFrameRecord(this.core.view(), at);
  }
  setGround(ground: Uint8Array): void {
    this.core.put(ground);
    this.core.exports.foreland_screen_ground(this.handle);
  }
  mapPosition(point: readonly number[]): MapPosition | null {
    const at = this.core.exports.foreland_screen_map_position(this.handle, point[0]!, point[1]!, point[2]!);
    if (at === 0) return null;
    const r = readMapPositionRecord(this.core.view(), at);
    const known = (v: number) => (Number.isNaN(v) ? null : v);
    return { ...r, ground_m: known(r.ground_m), slope_rad: known(r.slope_rad) };
  }
  // Where an eye comes to that moves from one point towards another above the ground (client/ground/sweep.h).
  sweep(from: readonly number[], to: readonly number[], clearance_m: number): [number, number, number] {
    const record = this.core.exports.foreland_screen_sweep(this.handle, from[0]!, from[1]!, from[2]!, to[0]!, to[1]!, to[2]!, clearance_m);
    return readPoseRecord(this.core.view(), record).eye;
  }
  // Begins the tour of the server's reply.
  startTour(reply: Uint8Array, start_ms: number): void {
    this.core.put(reply);
    this.core.exports.foreland_screen_tour(this.handle, start_ms);
  }
  // Null once the tour is over.
  tourPose(now_ms: number): Pose | null {
    const record = this.core.exports.foreland_screen_tour_pose(this.handle, now_ms);
    return record === 0 ? null : readPoseRecord(this.core.view(), record);
  }
}

function welcomeAt(core: Core, at: number): Welcome {
  const view = core.view();
  const r = readWelcomeRecord(view, at);
  const vectorAt = (address: number) => [0, 8, 16].map((i) => view.getFloat64(address + i, true)) as [number, number, number];
  return {
    low: r.low,
    high: r.high,
    lowest_m: r.lowest_m,
    highest_m: r.highest_m,
    tau_px: r.tau_px,
    keyframe_ms: r.keyframe_ms,
    title: core.text(r.title, r.title_size),
    crs: core.text(r.crs, r.crs_size),
    is_geographic: r.is_geographic === 1,
    samples: [r.samples_x, r.samples_y],
    model_has_image: Array.from({ length: r.model_count }, (_, i) => view.getUint32(r.model_sides + 4 * i, true) > 0),
    epochs_ms: Array.from({ length: r.epoch_count }, (_, i) => view.getFloat64(r.epochs + 8 * i, true)),
    most_moved_m: r.most_moved_m,
    landmarks: Array.from({ length: r.landmark_count }, (_, i) => vectorAt(r.landmarks + 24 * i)),
  };
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
    from_normals: new Int8Array(memory, r.from_normals, 4 * vertices),
    to_normals: new Int8Array(memory, r.to_normals, 4 * vertices),
    indices: new Uint32Array(memory, r.indices, r.index_count),
    from_nodes: r.from_nodes,
    to_nodes: r.to_nodes,
    to_index: r.to_index,
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

type RequestArguments = [number, number, number, number, number, number, number, number, number, number, number, number, number];

function requestArguments(r: Request): RequestArguments {
  const strategy = kStrategies.indexOf(r.strategy);
  return [r.fov_rad, r.width_px, r.height_px, r.tau_px, strategy, kPredictors.indexOf(r.predictor), r.keyframe_ms, r.longest_keyframe_ms ?? 0,
    r.occlusion ? 1 : 0, r.memory_bytes, r.relief ? 1 : 0, r.imagery ? 1 : 0, r.tile_bytes];
}
