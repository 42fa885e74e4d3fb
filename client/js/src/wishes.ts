// What is wanted of a terrain, and the request that the server is sent for it.
import type { Pose, Request, RequestedLens } from './core/values.js';
import { ForelandError } from './errors.js';
import { theHost } from './host.js';
import { kDefaultLens, requestedLens, requestOf, type Lens, type Limits, type OpenOptions, type TerrainOptions } from './options.js';

const kMaxPoses = 100_000; // of a path; proto/message/control.h
const kLongestStep_ms = 60_000;

/** @internal */
export class Wishes {
  options: TerrainOptions;
  readonly limits: Limits;
  private lens: Lens;
  private path_version = 0;
  private sent = '';

  constructor(opening: OpenOptions) {
    this.options = { ...opening };
    this.limits = opening.limits ?? {};
    this.lens = opening.lens ?? kDefaultLens;
  }

  // Whether it differs from the one before.
  setLens(lens: Lens): boolean {
    const { fovY, width, height } = this.lens;
    if (Math.abs(lens.fovY - fovY) < 1e-9 && lens.width === width && lens.height === height) return false;
    if (!(lens.fovY > 0 && lens.fovY < Math.PI && lens.width >= 1 && lens.height >= 1))
      throw new ForelandError('argument', `A lens of ${lens.fovY} radians and ${lens.width} x ${lens.height} pixels sees nothing.`);
    this.lens = { ...lens };
    return true;
  }

  // Seven numbers for each pose of the path that the camera takes from now on.
  setPath(poses: readonly Pose[], stepMs: number): Float64Array {
    const numbers = new Float64Array(7 * poses.length);
    poses.forEach(({ eye, orientation }, i) => numbers.set([...eye, ...orientation], 7 * i));
    if (poses.length === 1 || poses.length > kMaxPoses || !numbers.every(Number.isFinite) || !(stepMs >= 1 && stepMs <= kLongestStep_ms))
      throw new ForelandError('argument', `${poses.length} poses in steps of ${stepMs} ms are no path.`, 'A path has 2 to 100,000 poses of finite numbers, in steps of 1 ms to 60 s.');
    this.path_version = poses.length === 0 ? 0 : this.path_version + 1;
    return numbers;
  }

  get requestedLens(): RequestedLens {
    return requestedLens(this.lens, this.options.eyeRadius);
  }
  get request(): Request {
    const predictor = this.options.predictor ?? (this.path_version > 0 ? 'path' : 'velocity');
    return requestOf({ ...this.options, predictor }, this.limits, this.lens, theHost().has_bitmaps);
  }
  // The request, if it differs from the last one that was taken.
  takeRequest(): Request | null {
    const { request } = this, text = JSON.stringify(request);
    if (text === this.sent) return null;
    this.sent = text;
    return request;
  }
}
