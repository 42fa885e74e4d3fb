// Frames for people who keep them: each is drawn for one pose, and only once what is shown is the section for it, guaranteed, with its tiles.
// What a frame shows then follows from its pose, and not from when it is drawn or how long that takes.
import type { MeshUpdate, Pose, Terrain } from '@foreland/client';
import type { Picture } from './picture';

const kMoving_ms = 100; // after which keyframes are for a camera that rests: two intervals (kResting)
const kRounded = 1e-6; // of the scene: how far off the eye of a keyframe may be, as it is written
// Of a keyframe for a camera that rests, with what its numbers are rounded up by (server/view/viewer_motion.cpp: kPoseRounding). It is larger
// for ten keyframes after one whose pose had to be predicted, as where poses come late, and its section with it.
const kRestingRegion = { radius_m: 1.02 * 0.01, angle_rad: 1.02 * 4e-4 };
const kTexel_px = 2; // on the screen, that tiles which a view needs leave at most (server/imagery/tile_sender.h)
const kFinerEvery_ms = 300; // of keyframes: finer tiles of imagery than that come with every fifth
const kPatience = { ms: 30_000, meshes: 100 }; // both: where a processor draws and is busy, few meshes come in long
const kLook_ms = 4;
const kQuiet_ms = 1000; // after a change of the size, until keyframes of another size are over

export interface ExactFrame {
  canvas: HTMLCanvasElement;
  guaranteed_px: number; // what its error does not exceed
}

// Meshes that were shown one after another, and between which nothing has changed.
interface Still {
  update: MeshUpdate; // the last of them
  tiles_received: number;
  since_ms: number; // time of the keyframe that the first of them ends with
  meshes: number;
}

export class ExactFrames {
  private from_ms = -Infinity; // when keyframes of this size come
  private told: { pose: Pose; at_ms: number; meshes: number } | null = null; // that the server knows
  private still: Still | null = null;
  private readonly onMesh: (update: MeshUpdate) => void;

  constructor(private readonly picture: Picture, private readonly terrain: Terrain) {
    const ground = picture.ground!;
    this.onMesh = ground.onMesh;
    picture.name_texts.object.visible = false; // which are in sight is asked for while people fly
    ground.onMesh = (update) => {
      this.onMesh(update);
      this.note(update);
    };
  }
  end(): void {
    this.picture.name_texts.object.visible = true;
    if (this.picture.ground) this.picture.ground.onMesh = this.onMesh;
  }

  // An Error says in words that it is too large.
  resize(width: number, height: number): void {
    const { renderer } = this.picture, gl = renderer.getContext();
    this.picture.sizeExactly(width, height);
    if (gl.drawingBufferWidth < width || gl.drawingBufferHeight < height) throw new Error(`The graphics card draws no picture of ${width} \u00d7 ${height}.`);
    this.from_ms = performance.now() + kQuiet_ms;
  }

  // `take` is called with the frame as it is drawn: what it reads of the canvas at once is the frame. Rejects where it does not come. The
  // server is told of the pose that is wanted next, so that its section is made while this frame is drawn and kept.
  async draw<T>(pose: Pose, next: Pose | null, signal: AbortSignal, take: (frame: ExactFrame) => T): Promise<T> {
    for (;;) {
      signal.throwIfAborted();
      const drawn = this.look(pose);
      if (drawn) {
        const taken = take(drawn);
        if (next) this.tell(next);
        return taken;
      }
      await new Promise((resolve) => setTimeout(resolve, kLook_ms));
    }
  }

  private tell(pose: Pose): ReturnType<Picture['update']> {
    const now_ms = performance.now();
    if (this.told?.pose !== pose) {
      this.told = { pose, at_ms: now_ms, meshes: 0 };
      this.still = null;
    }
    return this.picture.update(now_ms, pose);
  }

  // The frame, drawn, if it is exact.
  private look(pose: Pose): ExactFrame | null {
    const { picture, terrain } = this;
    if (!terrain.isConnected) throw new Error('The connection is lost.');
    const frame = this.tell(pose), { at_ms, meshes } = this.told!;
    if (performance.now() - at_ms > kPatience.ms && meshes > kPatience.meshes) throw new Error('The server does not send this view as exactly as it is wanted.');
    if (!frame || frame.guaranteedPx === null || frame.version !== this.still?.update.version || !this.isSettled(this.still)) return null;
    picture.ground!.place(1, pose.eye); // both ends are the same, but for what blending rounds
    const place = terrain.place(pose.eye);
    picture.take({ frame, pose, camera_eye: pose.eye, above_ground_m: place && place.ground !== null ? place.height - place.ground : null }, place);
    return { canvas: picture.renderer.domElement, guaranteed_px: frame.guaranteedPx };
  }

  // A mesh begins to be shown.
  private note(update: MeshUpdate): void {
    const { told, still, terrain } = this;
    if (!told) return;
    ++told.meshes;
    const { low, high } = terrain.scene.bounds, within_m = kRounded * Math.hypot(high[0] - low[0], high[1] - low[1]);
    const is_for_pose = update.to_time_ms > Math.max(told.at_ms + kMoving_ms, this.from_ms) && isAt(update.to_pose, this.picture.asked(told.pose), within_m)
      && update.to_region.radius_m <= kRestingRegion.radius_m && update.to_region.angle_rad <= kRestingRegion.angle_rad;
    const { tiles_received } = terrain.stats;
    if (!is_for_pose) this.still = null;
    else if (still && still.tiles_received === tiles_received && isSame(still.update, update)) this.still = { ...still, update, meshes: still.meshes + 1 };
    else this.still = { update, tiles_received, since_ms: update.to_time_ms, meshes: 1 };
  }

  // Both ends of the mesh are the section for the pose, and no tile is missing or comes.
  private isSettled({ update, since_ms, meshes }: Still): boolean {
    const { scene: { layers }, request, stats } = this.terrain;
    const lacksTiles = (content: 'relief' | 'imagery', texel_px: number) => layers[content] && request[content] && texel_px > kTexel_px;
    if (lacksTiles('relief', stats.relief_texel_px) || lacksTiles('imagery', stats.imagery_texel_px)) return false;
    return meshes >= 2 && (!layers.imagery || !request.imagery || update.to_time_ms - since_ms >= kFinerEvery_ms);
  }
}

// Whether nothing has changed from one to the other.
function isSame(one: MeshUpdate, other: MeshUpdate): boolean {
  const isSameTable = (a: Uint16Array | undefined, b: Uint16Array | undefined) => a?.length === b?.length && (a?.every((v, i) => v === b![i]) ?? true);
  return one.changed_nodes === other.changed_nodes && one.to_pose.eye.every((v, k) => v === other.to_pose.eye[k]) && one.to_pose.orientation.every((v, k) => v === other.to_pose.orientation[k])
    && isSameTable(one.tiles.relief?.page_table, other.tiles.relief?.page_table) && isSameTable(one.tiles.imagery?.page_table, other.tiles.imagery?.page_table);
}

function isAt(one: Pose, other: Pose, within_m: number): boolean {
  const turned = Math.abs(one.orientation.reduce((sum, v, k) => sum + v * other.orientation[k]!, 0));
  return Math.hypot(...one.eye.map((v, k) => v - other.eye[k]!)) <= within_m && turned > 1 - 1e-7;
}
