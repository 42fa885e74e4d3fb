// What goes in and out of the client core (client/wasm): requests, meshes, frames. Arrays point into an instance's memory where
// nothing else is said.
import type { LayerRecord, MapPositionRecord, PoseRecord, SlopeFrameRecord, StatisticsRecord } from './records.js';

export type Pose = PoseRecord; // eye: scene frame, metres; orientation: x, y, z, w

export const kStrategies = ['delay', 'current', 'predict'] as const;
export const kPredictors = ['hold', 'velocity', 'acceleration', 'path', 'double-exponential', 'kalman'] as const;
export const kBlends = ['keyframe', 'geomorph', 'b-spline-2', 'b-spline-3'] as const; // client/mesh/weights/blend.h
export type Strategy = (typeof kStrategies)[number];
export type Predictor = (typeof kPredictors)[number];
export type Blend = (typeof kBlends)[number];

export interface RequestedLens {
  fov_rad: number;
  width_px: number;
  height_px: number;
  eye_radius_m?: number; // how far eyes that see a frame are from the camera's
}
export interface Request extends RequestedLens {
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
  max_triangles?: number; // that are drawn; 0 or absent: no limit
  max_bytes_per_second?: number; // that are received; 0 or absent: no limit
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

// Of a keyframe: its section keeps the tolerance for eyes this near to its pose, turned by no more than this.
export interface Region {
  radius_m: number;
  angle_rad: number;
}

export interface Mesh {
  version: number;
  oldest_version: number; // of meshes that may still be shown
  origin: [number, number, number];
  vertices: number;
  triangles: number;
  to_nodes: number;
  to_time_ms: number;
  to_pose: Pose;
  to_region: Region;
  texture_coordinates: Float32Array; // positions on the lattice
  from_positions: Float32Array;
  to_positions: Float32Array;
  from_moved: Float32Array; // metres upwards since the first epoch; empty if the ground does not move
  to_moved: Float32Array;
  from_bends: Float32Array; // empty if vertices move straight
  to_bends: Float32Array;
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
  bends: Uint32Array;
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
  frame: FrameKind;
  samples: [number, number];
  model_has_image: boolean[]; // of the objects' models
  epochs_ms: number[]; // since 1970, of a scene that changes in time
  max_moved_m: number; // by which its ground moves at most from the first epoch to another
  landmarks: [number, number, number][];
  scene_id: bigint;
  zero_surface: ZeroSurface;
  datum: string; // its name; empty: not stated
  geoid: string; // whose undulations are known; empty: none's
  undulation_error_m: number;
}

/** How a scene lies: on a map, on the earth about its origin, or as the whole body. */
export type FrameKind = 'planar' | 'geographic' | 'globe';
export const kFrameKinds: readonly FrameKind[] = ['planar', 'geographic', 'globe']; // in the order of proto/space/frame.h

/** What heights count from: an ellipsoid, the level of the sea, or nobody says. */
export type ZeroSurface = 'unstated' | 'ellipsoid' | 'sea';
export const kZeroSurfaces: readonly ZeroSurface[] = ['unstated', 'ellipsoid', 'sea']; // in the order of proto/space/vertical.h

// A point of the scene as client/wasm/records.h has it; null where the ground is not known.
export type MapPosition = Omit<MapPositionRecord, 'ground_m' | 'slope_rad' | 'undulation_m'> & {
  ground_m: number | null; slope_rad: number | null;
  undulation_m: number | null; // null: not known
};
export type Statistics = StatisticsRecord;

export const kTileSide = 256; // texels; proto/imagery/tile.h
