// What a worker does for overlays (overlay_worker.ts), so that no frame waits for a file.
import type { Overlay, Places } from './feature';
import { buildGroundGrid, type GroundGrid, type GroundShape, type Point } from './ground_grid';
import { readOverlay, type OverlayMap } from './read_overlay';
import { trackIn } from './track_in';

export type FlatShape = Omit<GroundShape, 'parts'> & { parts: Places[] }; // on the lattice

export interface OverlayWork {
  read: { given: { name: string; bytes: Uint8Array<ArrayBuffer>; map: OverlayMap }; made: Overlay };
  track: { given: { name: string; bytes: Uint8Array<ArrayBuffer> }; made: { json: unknown } };
  lay: { given: { shapes: FlatShape[] }; made: GroundGrid };
}

// Both ends move what is made; an Error says what is wrong.
export const kOverlayWork: { [K in keyof OverlayWork]: (given: OverlayWork[K]['given']) => OverlayWork[K]['made'] } = {
  read: ({ name, bytes, map }) => readOverlay(name, bytes, map),
  track: ({ name, bytes }) => ({ json: trackIn(name, bytes) }),
  lay: ({ shapes }) => buildGroundGrid(shapes.map((shape) => ({ ...shape, parts: shape.parts.map(pointsOf) }))),
};

export function buffersOf(made: OverlayWork[keyof OverlayWork]['made']): ArrayBuffer[] {
  if ('json' in made) return [];
  if ('cells' in made) return [made.cells, made.items, made.segments, made.styles, made.features].map((numbers) => numbers.buffer);
  return made.features.flatMap(({ parts }) => parts.map((part) => part.buffer));
}

function pointsOf(flat: Places): Point[] {
  return Array.from({ length: flat.length / 2 }, (_, i) => [flat[2 * i]!, flat[2 * i + 1]!]);
}
