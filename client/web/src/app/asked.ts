// What the settings ask of the server, and what this device may take.
import type { Lens, Limits, TerrainOptions } from '@foreland/client';
import { adapts, kAdaptive_ms, kLens, type Settings } from '../ui/settings';

export const kIsPhone = window.matchMedia('(pointer: coarse)').matches;

// Phones have less to spare.
export const kLimits: Limits = {
  memoryBytes: (kIsPhone ? 6 : 16) << 20, // for terrain that was flown over
  tileBytes: (kIsPhone ? 32 : 64) << 20, // of coded tiles
  textureLayers: kIsPhone ? { relief: 32, imagery: 96 } : { relief: 64, imagery: 256 },
};

// `finer`: by which the tolerance is smaller than what is wanted (Picture.exaggerate); `eyeRadius`: of eyes in a headset.
export function optionsOf(settings: Settings, is_touring: boolean, finer: number, eyeRadius: number): TerrainOptions {
  const { strategy, predictor, blend, tau_px, keyframe_ms, occlusion, relief, imagery } = settings;
  const automatic = is_touring ? 'path' : 'velocity';
  return {
    strategy, blend, occlusion, relief, imagery, eyeRadius, tolerancePx: tau_px / finer, predictor: predictor === 'auto' ? automatic : predictor,
    keyframeMs: adapts(settings) ? kAdaptive_ms : keyframe_ms,
  };
}

// Of a camera that rests until its view is exact. Keyframes are for poses that the server has been told, so no prediction's error widens
// what they are for, and nothing that was hidden before fades: at rest the section follows from the pose alone.
export const kResting: TerrainOptions = { strategy: 'delay', predictor: 'hold', blend: 'keyframe', keyframeMs: 50, occlusion: false };

export function lensOf({ width, height }: HTMLCanvasElement): Lens {
  return { fovY: kLens.fov_rad, width, height };
}
