// How far about the eye the ground is needed before the worker tells it again: so many frames ahead.
import type { Welcome } from './core/values.js';
import type { Vector } from './scene.js';

const kFrames = 8;
const kMost = 4096; // samples

/** @internal */
export class GroundReach {
  private last: Vector = [0, 0, 0];

  // Samples, for an eye that was elsewhere in the frame before.
  of({ low, high, samples }: Welcome, eye: readonly number[]): number {
    const spacing_m = Math.hypot(high[0] - low[0], high[1] - low[1]) / Math.hypot(...samples);
    const step_m = Math.hypot(...this.last.map((v, i) => eye[i]! - v));
    this.last = [eye[0]!, eye[1]!, eye[2]!];
    return Math.min(Math.max(1, (kFrames * step_m) / spacing_m), kMost);
  }
}
