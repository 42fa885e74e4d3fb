// How ground looks, whatever lights it.
import type { Tints } from './colour_map.js';

/**
 * How ground is coloured: as it may look, or by the picture that is laid over it (`natural`); in one colour; by how steep it is, and where
 * it falls to; by its height, with a colour map; and by how far it has moved since the first epoch.
 */
export const kGrounds = ['natural', 'plain', 'slope', 'aspect', 'heights', 'change'] as const;
export type Ground = (typeof kGrounds)[number];

/** The look of the ground. `ForelandTerrain.setStyle` changes what is given and leaves the rest. */
export interface Style {
  ground: Ground;
  /** Shade by relief, finer than the mesh. Needs the terrain's option `relief`. */
  relief: boolean;
  /** Lay the picture over the ground. Needs the terrain's option `imagery`. */
  imagery: boolean;
  contours: boolean;
  /** Where snow begins, from 0, the lowest ground, to 1, the highest; above 1 there is none. */
  snowLine: number;
  /** Of `change`: the share of the largest motion that has the strongest colours. */
  change: number;
  /** Of `heights`; null: grey. */
  tints: Tints | null;
  /** Towards the sun whose shadows the relief has, in the scene's axes. */
  sun: readonly [number, number, number];
  /** Shadows that ground casts on ground by relief, as far as the data go. They darken the direct light of all lights. */
  reliefShadows: boolean;
  /** Draws the edges of the mesh. */
  wireframe: boolean;
}

/** What a `ForelandTerrain` begins with. */
export const kDefaultStyle: Style = {
  ground: 'natural', relief: true, imagery: true, contours: false, snowLine: 0.75, change: 1, tints: null, sun: [-0.571, 0.571, 0.589], reliefShadows: false,
  wireframe: false,
};
