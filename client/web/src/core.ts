// The client core (client/wasm) as the page sees it: a module to load once, a Viewer for each connection. Records are read
// at the offsets of client/wasm/records.h. Arrays point into the module's memory and are valid until the next call into it.

export interface Pose {
  eye: [number, number, number]; // scene frame, metres
  orientation: [number, number, number, number]; // x, y, z, w
}

export const kStrategies = ['delay', 'current', 'predict'] as const;
export const kPredictors = ['hold', 'velocity', 'acceleration', 'path'] as const;
export const kBlends = ['keyframe', 'geomorph'] as const; // client/blend.h
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
}

export interface Mesh {
  version: number;
  origin: [number, number, number];
  vertices: number;
  triangles: number;
  from_nodes: number;
  to_nodes: number;
  to_index: number;
  to_time_ms: number;
  to_pose: Pose;
  tau_px: number;
  from_positions: Float32Array;
  to_positions: Float32Array;
  from_normals: Int8Array;
  to_normals: Int8Array;
  indices: Uint32Array;
  objects: ObjectArrays;
}

// The same of all objects; `places` in their models' images, `parts` of each: first index, number of indices, model.
export interface ObjectArrays {
  vertices: number;
  from_positions: Float32Array;
  to_positions: Float32Array;
  from_normals: Int8Array;
  to_normals: Int8Array;
  places: Float32Array;
  indices: Uint32Array;
  parts: Uint32Array;
}

export interface Frame {
  pose: Pose;
  scene_time_ms: number;
  weight: number;
  mesh_version: number; // 0: no mesh yet
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
  landmarks: [number, number, number][];
}

export interface Place {
  height_m: number;
  ground_m: number | null;
  up: [number, number, number];
  across: [number, number];
}

export interface Statistics {
  bytes_down: number;
  bytes_up: number;
  last_lateness_ms: number;
  worst_lateness_ms: number;
  keyframes: number;
  late_keyframes: number;
}

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  foreland_buffer(size: number): number;
  foreland_create(fov: number, w: number, h: number, tau: number, strategy: number, predictor: number, interval_ms: number): number;
  foreland_destroy(viewer: number): void;
  foreland_reconnect(viewer: number, now_ms: number): void;
  foreland_receive(viewer: number, now_ms: number): number;
  foreland_take_outgoing(viewer: number): number;
  foreland_error(viewer: number): number;
  foreland_frame(viewer: number, now_ms: number, ...pose: number[]): number;
  foreland_set_request(viewer: number, fov: number, w: number, h: number, tau: number, strategy: number, predictor: number,
                       interval_ms: number): void;
  foreland_set_blend(viewer: number, blend: number): number;
  foreland_request_tour(viewer: number, seconds: number): void;
  foreland_take_tour(viewer: number): number;
  foreland_start_tour(viewer: number, start_ms: number): void;
  foreland_tour_pose(viewer: number, now_ms: number): number;
  foreland_welcome(viewer: number): number;
  foreland_place(viewer: number, x: number, y: number, z: number): number;
  foreland_statistics(viewer: number): number;
}

export class Core {
  private constructor(readonly exports: Exports) {}

  static async load(url: string): Promise<Core> {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url}: HTTP ${response.status}`);
    const module = await WebAssembly.compile(await response.arrayBuffer());
    let memory: WebAssembly.Memory | undefined;
    const instance = await WebAssembly.instantiate(module, wasiImports(module, () => memory!));
    const exports = instance.exports as unknown as Exports;
    memory = exports.memory;
    exports._initialize();
    return new Core(exports);
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
}

// The module uses no system: what it says goes to the console, an exit is an error, anything else is "not supported".
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

// One session's client side.
export class Viewer {
  private readonly handle: number;
  private frame_record = 0;

  constructor(private readonly core: Core, request: Request) {
    this.handle = core.exports.foreland_create(...requestArguments(request));
  }

  // There is a new connection after one that was lost: goes on from the section held, if the scene is the same.
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
    return this.textAt(this.core.exports.foreland_error(this.handle));
  }
  takeOutgoing(): Uint8Array<ArrayBuffer> | null {
    const record = this.core.exports.foreland_take_outgoing(this.handle);
    if (record === 0) return null;
    const view = this.core.view();
    return this.core.copy(view.getUint32(record, true), view.getUint32(record + 4, true));
  }
  setRequest(request: Request): void {
    this.core.exports.foreland_set_request(this.handle, ...requestArguments(request));
  }

  // From the next keyframe on; what is on its way goes on from where it is.
  setBlend(blend: Blend): void {
    this.core.exports.foreland_set_blend(this.handle, kBlends.indexOf(blend));
  }

  frame(now_ms: number, pose: Pose): Frame {
    this.frame_record = this.core.exports.foreland_frame(this.handle, now_ms, ...pose.eye, ...pose.orientation);
    const view = this.core.view();
    return {
      pose: poseAt(view, this.frame_record),
      scene_time_ms: view.getFloat64(this.frame_record + 80, true),
      weight: view.getFloat32(this.frame_record + 160, true),
      mesh_version: view.getUint32(this.frame_record + 164, true),
    };
  }
  // The mesh of the last frame().
  mesh(): Mesh {
    const at = this.frame_record;
    const view = this.core.view();
    const memory = view.buffer as ArrayBuffer;
    const u32 = (offset: number) => view.getUint32(at + offset, true);
    const vertices = u32(168);
    const indices = u32(172);
    return {
      version: u32(164),
      origin: vectorAt(view, at + 56),
      vertices,
      triangles: indices / 3,
      to_time_ms: view.getFloat64(at + 96, true),
      to_pose: poseAt(view, at + 104),
      from_positions: new Float32Array(memory, u32(176), 4 * vertices),
      to_positions: new Float32Array(memory, u32(180), 4 * vertices),
      from_normals: new Int8Array(memory, u32(184), 4 * vertices),
      to_normals: new Int8Array(memory, u32(188), 4 * vertices),
      indices: new Uint32Array(memory, u32(192), indices),
      from_nodes: u32(196),
      to_nodes: u32(200),
      to_index: u32(208),
      tau_px: view.getFloat32(at + 212, true),
      objects: {
        vertices: u32(216),
        from_positions: new Float32Array(memory, u32(224), 4 * u32(216)),
        to_positions: new Float32Array(memory, u32(228), 4 * u32(216)),
        from_normals: new Int8Array(memory, u32(232), 4 * u32(216)),
        to_normals: new Int8Array(memory, u32(236), 4 * u32(216)),
        places: new Float32Array(memory, u32(240), 2 * u32(216)),
        indices: new Uint32Array(memory, u32(244), u32(220)),
        parts: new Uint32Array(memory, u32(248), 3 * u32(252)),
      },
    };
  }

  requestTour(name: string, seconds: number): void {
    this.core.put(new TextEncoder().encode(name));
    this.core.exports.foreland_request_tour(this.handle, seconds);
  }
  // True once for each tour that arrived.
  takeTour(): boolean {
    return this.core.exports.foreland_take_tour(this.handle) > 0;
  }
  startTour(start_ms: number): void {
    this.core.exports.foreland_start_tour(this.handle, start_ms);
  }
  // Null when the tour is over.
  tourPose(now_ms: number): Pose | null {
    const record = this.core.exports.foreland_tour_pose(this.handle, now_ms);
    return record === 0 ? null : poseAt(this.core.view(), record);
  }

  welcome(): Welcome | null {
    const at = this.core.exports.foreland_welcome(this.handle);
    if (at === 0) return null;
    const view = this.core.view();
    const u32 = (offset: number) => view.getUint32(at + offset, true);
    const f64 = (offset: number) => view.getFloat64(at + offset, true);
    return {
      low: vectorAt(view, at),
      high: vectorAt(view, at + 24),
      lowest_m: f64(48),
      highest_m: f64(56),
      tau_px: f64(64),
      keyframe_ms: f64(72),
      title: this.core.text(u32(80), u32(84)),
      crs: this.core.text(u32(88), u32(92)),
      is_geographic: u32(96) === 1,
      samples: [u32(100), u32(104)],
      landmarks: Array.from({ length: u32(108) }, (_, i) => vectorAt(view, u32(112) + 24 * i)),
    };
  }
  place(point: readonly number[]): Place | null {
    const at = this.core.exports.foreland_place(this.handle, point[0]!, point[1]!, point[2]!);
    if (at === 0) return null;
    const view = this.core.view();
    const ground_m = view.getFloat64(at + 8, true);
    return {
      height_m: view.getFloat64(at, true),
      ground_m: Number.isNaN(ground_m) ? null : ground_m,
      up: vectorAt(view, at + 16),
      across: [view.getFloat64(at + 40, true), view.getFloat64(at + 48, true)],
    };
  }
  statistics(): Statistics {
    const at = this.core.exports.foreland_statistics(this.handle);
    const view = this.core.view();
    return {
      bytes_down: view.getFloat64(at, true),
      bytes_up: view.getFloat64(at + 8, true),
      last_lateness_ms: view.getFloat64(at + 16, true),
      worst_lateness_ms: view.getFloat64(at + 24, true),
      keyframes: view.getUint32(at + 48, true),
      late_keyframes: view.getUint32(at + 52, true),
    };
  }

  private textAt(record: number): string {
    const view = this.core.view();
    return this.core.text(view.getUint32(record, true), view.getUint32(record + 4, true));
  }
}

function requestArguments(r: Request): [number, number, number, number, number, number, number] {
  const strategy = kStrategies.indexOf(r.strategy);
  return [r.fov_rad, r.width_px, r.height_px, r.tau_px, strategy, kPredictors.indexOf(r.predictor), r.keyframe_ms];
}

function vectorAt(view: DataView, at: number): [number, number, number] {
  return [view.getFloat64(at, true), view.getFloat64(at + 8, true), view.getFloat64(at + 16, true)];
}

function poseAt(view: DataView, at: number): Pose {
  const q = at + 24;
  return {
    eye: vectorAt(view, at),
    orientation: [view.getFloat64(q, true), view.getFloat64(q + 8, true), view.getFloat64(q + 16, true), view.getFloat64(q + 24, true)],
  };
}
