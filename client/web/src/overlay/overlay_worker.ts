// The worker's entry: one task, one answer.
import { buffersOf, kOverlayWork, type OverlayWork } from './overlay_work';

onmessage = ({ data: { kind, given } }: MessageEvent<{ kind: keyof OverlayWork; given: never }>) => {
  try {
    const made = kOverlayWork[kind](given);
    postMessage({ made }, { transfer: buffersOf(made) });
  } catch (error) {
    postMessage({ wrong: error instanceof Error ? error.message : String(error) });
  }
};
