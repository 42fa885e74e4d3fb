// What a terrain is opened with, and what of it can be changed in flight.
import type { Blend, Predictor, Request, RequestedLens, Strategy } from './core/values.js';

export type { Blend, Predictor, Strategy };

/** What can be changed in flight, by `setOptions`. */
export interface TerrainOptions {
  /** Largest error on the screen, in pixels of the lens. Default 1. */
  tolerancePx?: number;
  /** `predict` (default) draws for where the camera will be, `current` for where it is as the server answers, `delay` shows everything late. */
  strategy?: Strategy;
  /** How the server foresees the camera. Default `velocity`; `path` once a path has been announced. */
  predictor?: Predictor;
  /** How the mesh goes from one keyframe to the next. Default `keyframe`. */
  blend?: Blend;
  /** Leave out what ridges hide, where the server can. Default true. */
  occlusion?: boolean;
  /** Send tiles of relief, by which ground is shaded finer than its mesh. Default true. */
  relief?: boolean;
  /** Send tiles of imagery. Default true; in Node, which decodes no images, false. */
  imagery?: boolean;
  /** Milliseconds between keyframes, or the bounds between which the server chooses. Default 200. */
  keyframeMs?: number | { shortest: number; longest: number };
  /** How far the eyes that see a frame are from the camera, metres, as the two of a head: what is guaranteed holds for each. At most 100. Default 0. */
  eyeRadius?: number;
}

/** What a terrain may take. A connection's first request decides, so these are fixed once it is open. */
export interface Limits {
  /** For terrain that was flown over, bytes. Default 16 MiB. */
  memoryBytes?: number;
  /** Of coded tiles, bytes. Default 64 MiB. */
  tileBytes?: number;
  /** How many tiles the graphics card holds. Default 64 of relief, 256 of imagery. */
  textureLayers?: { relief: number; imagery: number };
  /** Triangles of ground and objects at once. Where the tolerance takes more, the server raises it, and `guaranteedPx` says so. Default: no limit. */
  triangles?: number;
  /** What the server sends in a second, bytes, likewise. Default: what the connection takes. */
  bytesPerSecond?: number;
}

/** What the camera sees: the vertical angle in radians, and the picture in pixels. */
export interface Lens {
  fovY: number;
  width: number;
  height: number;
}

export interface OpenOptions extends TerrainOptions {
  /** For a server that asks for one (`foreland token`). */
  token?: string;
  limits?: Limits;
  /** Default 55 degrees, 1280 x 720. `ForelandTerrain` sets the camera's. */
  lens?: Lens;
  /** Where foreland.wasm is, or the module itself. Default: beside the package's own script. */
  wasm?: URL | string | WebAssembly.Module;
  /** Where worker.js is, or a worker that runs it. Default: beside the package's own script. */
  worker?: URL | string | Worker;
  /** Aborting it before the session has begun rejects `open`; later it closes the terrain. */
  signal?: AbortSignal;
  /** How long `open` waits for a session to begin. Default 30 s; `Infinity` waits for good. */
  patienceMs?: number;
  /** Keeps all that comes in, for `saveRecording()`. */
  record?: boolean;
}

/** @internal */
export const kDefaultLens: Lens = { fovY: (55 * Math.PI) / 180, width: 1280, height: 720 };

/** @internal */
export function requestedLens({ fovY, width, height }: Lens, eyeRadius = 0): RequestedLens {
  return { fov_rad: fovY, width_px: Math.round(width), height_px: Math.round(height), eye_radius_m: eyeRadius };
}

/** @internal */
export function requestOf(options: TerrainOptions, limits: Limits, lens: Lens, has_bitmaps: boolean): Request {
  const keyframe = options.keyframeMs ?? 200;
  const [shortest, longest] = typeof keyframe === 'number' ? [keyframe, 0] : [keyframe.shortest, keyframe.longest];
  return {
    ...requestedLens(lens, options.eyeRadius),
    strategy: options.strategy ?? 'predict',
    predictor: options.predictor ?? 'velocity',
    tau_px: options.tolerancePx ?? 1,
    keyframe_ms: shortest,
    longest_keyframe_ms: longest,
    occlusion: options.occlusion ?? true,
    memory_bytes: limits.memoryBytes ?? 16 << 20,
    relief: options.relief ?? true,
    imagery: (options.imagery ?? true) && has_bitmaps,
    tile_bytes: limits.tileBytes ?? 64 << 20,
    max_triangles: limits.triangles ?? 0,
    max_bytes_per_second: limits.bytesPerSecond ?? 0,
  };
}

/** @internal */
export function layersOf(limits: Limits): { relief: number; imagery: number } {
  return limits.textureLayers ?? { relief: 64, imagery: 256 };
}
