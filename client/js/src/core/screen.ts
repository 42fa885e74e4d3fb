// A screen in the client core, of the thread that draws.
import { type Core, welcomeAt } from './core.js';
import { readLayerRecord, readMapPositionRecord, readPoseRecord, readScreenRecord, readSlopeFrameRecord } from './records.js';
import {
  kContents, kStrategies, type Content, type Layer, type MapPosition, type Pose, type RequestedLens, type ScreenFrame, type SlopeFrame, type Strategy, type Welcome,
} from './values.js';

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
  // Forgets all meshes: those that are added from now on are shown.
  redraw(): void {
    this.core.exports.foreland_screen_redraw(this.handle);
  }
  // The version to make ready next; 0: none.
  next(): number {
    return this.core.exports.foreland_screen_next(this.handle);
  }
  // The camera of the next frame is jumped to.
  jump(): void {
    this.core.exports.foreland_screen_jump(this.handle);
  }
  // If the mesh of version `ready` can be shown, and the one that was shown last. A mesh whose time has come before it is ready
  // begins when it is; `coming` is being made ready.
  frame(now_ms: number, pose: Pose, { fov_rad, width_px, height_px, eye_radius_m }: RequestedLens, strategy: Strategy, ready: number, coming: number): ScreenFrame {
    const more = [...pose.eye, ...pose.orientation, fov_rad, width_px, height_px, eye_radius_m ?? 0, kStrategies.indexOf(strategy), ready, coming];
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
    return { ...r, ground_m: known(r.ground_m), slope_rad: known(r.slope_rad), undulation_m: known(r.undulation_m) };
  }
  // The point of the scene at a place that the data's owner names (MapPosition.across) and a height above the zero surface; null before
  // the welcome.
  scenePoint(across: readonly [number, number], height_m: number): [number, number, number] | null {
    const record = this.core.exports.foreland_screen_scene_point(this.handle, across[0], across[1], height_m);
    return record === 0 ? null : readPoseRecord(this.core.view(), record).eye;
  }
  // Where a ray meets the ground that is held (client/ground/ray.h).
  ray(origin: readonly number[], direction: readonly number[], far_m: number): [number, number, number] | null {
    const record = this.core.exports.foreland_screen_ray(this.handle, origin[0]!, origin[1]!, origin[2]!, direction[0]!, direction[1]!, direction[2]!, far_m);
    return record === 0 ? null : readPoseRecord(this.core.view(), record).eye;
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
