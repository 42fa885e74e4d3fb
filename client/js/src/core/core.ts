// The client core (client/wasm) as JavaScript sees it: a module to compile once, with an instance for each thread. The worker has a
// Viewer for each session (worker/viewer.ts), the drawing thread a Screen (screen.ts). Arrays point into the instance's memory and are valid
// until the next call into it.
import { CoreError, reasonOf } from './failure.js';
import { kRecordLayout, readTextRecord, readWelcomeRecord } from './records.js';
import { kFrameKinds, kZeroSurfaces, type Welcome } from './values.js';

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  foreland_record_layout(): number;
  foreland_buffer(size: number): number;
  foreland_create(): number;
  foreland_destroy(viewer: number): void;
  foreland_reconnect(viewer: number, now_ms: number): void;
  foreland_receive(viewer: number, now_ms: number): number;
  foreland_take_outgoing(viewer: number): number;
  foreland_error(viewer: number): number;
  foreland_jump(viewer: number): void;
  foreland_frame(viewer: number, now_ms: number, ...pose: number[]): number;
  foreland_draw_ahead(viewer: number): void;
  foreland_redraw(viewer: number): void;
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
  foreland_set_request(viewer: number): void;
  foreland_set_blend(viewer: number, blend: number): number;
  foreland_set_scene_clock(viewer: number, at_ms: number, scene_ms: number, rate: number): void;
  foreland_request_tour(viewer: number, seconds: number): void;
  foreland_take_tour(viewer: number): number;
  foreland_start_tour(viewer: number, start_ms: number): void;
  foreland_request_ground(viewer: number): number;
  foreland_take_ground(viewer: number, request: number): number;
  foreland_announce_path(viewer: number, start_ms: number, step_ms: number): number;
  foreland_request_sight(viewer: number, above: number, refraction: number, scene_ms: number): number;
  foreland_request_viewshed(viewer: number, ...question: number[]): number;
  foreland_cancel_request(viewer: number, id: number): void;
  foreland_take_sight(viewer: number): number;
  foreland_read_sight(): number;
  foreland_sight_error(): number;
  foreland_welcome(viewer: number): number;
  foreland_area(viewer: number): number;
  foreland_statistics(viewer: number): number;
  foreland_screen_create(): number;
  foreland_screen_add(screen: number, oldest_version: number): void;
  foreland_screen_next(screen: number): number;
  foreland_screen_jump(screen: number): void;
  foreland_screen_redraw(screen: number): void;
  foreland_screen_frame(screen: number, now_ms: number, ...more: number[]): number;
  foreland_screen_welcome(screen: number): number;
  foreland_screen_layer(screen: number, content: number): number;
  foreland_screen_slope_frame(screen: number): number;
  foreland_screen_ground(screen: number): void;
  foreland_screen_sweep(screen: number, ...path: number[]): number;
  foreland_screen_ray(screen: number, ...ray: number[]): number;
  foreland_screen_map_position(screen: number, x: number, y: number, z: number): number;
  foreland_screen_scene_point(screen: number, across_0: number, across_1: number, height_m: number): number;
  foreland_screen_tour(screen: number, start_ms: number): number;
  foreland_screen_tour_pose(screen: number, now_ms: number): number;
}

export class Core {
  private constructor(readonly module: WebAssembly.Module, readonly exports: Exports) {}

  // Throws an Error if the module is of another version than this code.
  static async load(module: WebAssembly.Module): Promise<Core> {
    const core = await Core.of(module);
    if (core.textAt(core.exports.foreland_record_layout()) !== kRecordLayout) throw new Error('foreland.wasm and the client are of different versions.');
    return core;
  }

  // An instance of a module that another thread has loaded. Throws a CoreError.
  static async of(module: WebAssembly.Module): Promise<Core> {
    try {
      return await Core.startOf(module);
    } catch (error) {
      throw new CoreError('core start', reasonOf(error), { cause: error });
    }
  }
  private static async startOf(module: WebAssembly.Module): Promise<Core> {
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
    throw new CoreError('core', `It stopped with code ${code}.`);
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

export function welcomeAt(core: Core, at: number): Welcome {
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
    frame: kFrameKinds[r.frame_kind] ?? 'planar',
    samples: [r.samples_x, r.samples_y],
    model_has_image: Array.from({ length: r.model_count }, (_, i) => view.getUint32(r.model_sides + 4 * i, true) > 0),
    epochs_ms: Array.from({ length: r.epoch_count }, (_, i) => view.getFloat64(r.epochs + 8 * i, true)),
    max_moved_m: r.max_moved_m,
    zero_surface: kZeroSurfaces[r.zero_surface] ?? 'unstated',
    datum: core.text(r.datum, r.datum_size),
    geoid: core.text(r.geoid, r.geoid_size),
    undulation_error_m: r.undulation_error_m,
    scene_id: BigInt(r.scene_id[0]) | (BigInt(r.scene_id[1]) << 32n),
    landmarks: Array.from({ length: r.landmark_count }, (_, i) => vectorAt(r.landmarks + 24 * i)),
  };
}
