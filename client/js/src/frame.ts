// What to draw at an instant, as the client core tells it.
import type { Pose, ScreenFrame } from './core/values.js';

/** What to draw at an instant. */
export interface Frame {
  /** Of the mesh to draw; 0: there is none yet. */
  readonly version: number;
  /** Where between its two ends the mesh is drawn, from 0 to 1. */
  readonly weight: number;
  /** To draw from: what `frame` was given, but for the strategy `delay`. */
  readonly pose: Pose;
  /** What the error on the screen does not exceed, in pixels; null: nothing is guaranteed. */
  readonly guaranteedPx: number | null;
  /** Whose ground is shown, milliseconds since 1970, in scenes that change in time. */
  readonly sceneTime: number;
  /** Whose view is shown. */
  readonly shownTime: number;
  /** When the next mesh begins, unless it is late. */
  readonly endTime: number;
  /** The time of the newer keyframe, and the pose that it was computed for. */
  readonly to: { readonly time: number; readonly pose: Pose };
}

/** @internal Of a terrain that has no session yet. */
export const kNoFrame: Frame = {
  version: 0, weight: 0, pose: { eye: [0, 0, 0], orientation: [0, 0, 0, 1] }, guaranteedPx: null, sceneTime: 0, shownTime: 0, endTime: 0,
  to: { time: 0, pose: { eye: [0, 0, 0], orientation: [0, 0, 0, 1] } },
};

/** @internal */
export function frameOf(shown: ScreenFrame): Frame {
  return {
    version: shown.mesh_version, weight: shown.weight, pose: shown.pose, guaranteedPx: Number.isFinite(shown.tau_px) && shown.mesh_version > 0 ? shown.tau_px : null,
    sceneTime: shown.scene_time_ms, shownTime: shown.shown_time_ms, endTime: shown.end_ms, to: { time: shown.to_time_ms, pose: shown.to_pose },
  };
}
