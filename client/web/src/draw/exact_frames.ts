// Frames for people who keep them: each is drawn for one pose, and only once what is shown is the section for it, guaranteed, with its tiles.
import type { Pose, Terrain } from '@foreland/client';
import type { Picture } from './picture';

const kMeshes = 3; // one after another, for the pose: the last one begins and ends with it
const kUnderWay_ms = 200; // keyframes that may still be for the pose before
const kRounded = 1e-6; // of the scene: how far off the eye of a keyframe may be, as it is written
const kPatience_ms = 30_000;
const kQuiet_ms = 1000; // after a change of the size, until keyframes of another size are over

export interface ExactFrame {
  canvas: HTMLCanvasElement;
  guaranteed_px: number; // what its error does not exceed
}

export class ExactFrames {
  private from_ms = -Infinity; // when keyframes of this size come
  constructor(private readonly picture: Picture, private readonly terrain: Terrain) {}

  // An Error says in words that it is too large.
  resize(width: number, height: number): void {
    const { renderer } = this.picture, gl = renderer.getContext();
    this.picture.sizeExactly(width, height);
    if (gl.drawingBufferWidth < width || gl.drawingBufferHeight < height) throw new Error(`The graphics card draws no picture of ${width} \u00d7 ${height}.`);
    this.from_ms = performance.now() + kQuiet_ms;
  }

  // `take` is called with the frame as it is drawn: what it reads of the canvas at once is the frame. Rejects where it does not come.
  draw<T>(pose: Pose, signal: AbortSignal, take: (frame: ExactFrame) => T): Promise<T> {
    const { picture, terrain } = this, { renderer } = picture, begin_ms = performance.now();
    let [version, meshes, tiles] = [-1, 0, -1];
    const { low, high } = terrain.scene.bounds, across_m = Math.hypot(high[0] - low[0], high[1] - low[1]);
    const look = (): ExactFrame | null => {
      const now_ms = performance.now();
      if (!terrain.isConnected) throw new Error('The connection is lost.');
      if (now_ms - begin_ms > kPatience_ms) throw new Error('The server does not send this view as exactly as it is wanted.');
      const frame = picture.update(now_ms, pose);
      if (!frame || frame.version === version || now_ms < this.from_ms) return null;
      const is_same = frame.to.time > begin_ms + kUnderWay_ms && isAt(frame.to.pose, pose, kRounded * across_m) && terrain.stats.tiles === tiles;
      [version, tiles, meshes] = [frame.version, terrain.stats.tiles, is_same ? meshes + 1 : 0];
      if (meshes < kMeshes || frame.guaranteedPx === null) return null;
      const place = terrain.place(pose.eye);
      picture.take({ frame, pose, camera_eye: pose.eye, above_ground_m: place && place.ground !== null ? place.height - place.ground : null }, place);
      return { canvas: renderer.domElement, guaranteed_px: frame.guaranteedPx };
    };
    return new Promise((resolve, reject) => {
      const end = (settle: () => void) => {
        renderer.setAnimationLoop(null);
        settle();
      };
      renderer.setAnimationLoop(() => {
        try {
          signal.throwIfAborted();
          const drawn = look();
          if (!drawn) return;
          const taken = take(drawn);
          end(() => resolve(taken));
        } catch (error) {
          end(() => reject(error instanceof Error ? error : new Error(String(error))));
        }
      });
    });
  }
}

function isAt(one: Pose, other: Pose, within_m: number): boolean {
  const turned = Math.abs(one.orientation.reduce((sum, v, k) => sum + v * other.orientation[k]!, 0));
  return Math.hypot(...one.eye.map((v, k) => v - other.eye[k]!)) <= within_m && turned > 1 - 1e-7;
}
