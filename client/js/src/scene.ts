// A scene as its user sees it: plain, frozen values made of the server's welcome.
import type { Screen } from './core/screen.js';
import type { FrameKind, Layer, MapPosition, Welcome, ZeroSurface } from './core/values.js';

export type Vector = [number, number, number];

/** A place on the earth, in degrees; or on the map of a scene whose data are projected, in its metres. */
export type MapPoint = { lon: number; lat: number; height?: number } | { easting: number; northing: number; height?: number };

/** A height by both surfaces, metres; null where the scene does not say what its heights count from, or knows no geoid. */
export interface BothHeights {
  /** Above the sea: H. */
  aboveSea: number | null;
  /** Above the ellipsoid, as satellites tell it: h. */
  aboveEllipsoid: number | null;
}

/** A place of the scene in the coordinates of the data's owner. */
export type Place = MapPoint & BothHeights & {
  /** Metres above the zero surface of the data. */
  height: number;
  /** Height of the ground there, of what is held; null where it is not known. */
  ground: number | null;
  /** Slope of the ground, radians; null where it is not known. */
  slope: number | null;
  /** Away from the zero surface, in the scene's axes. */
  up: Vector;
  /** Position on the lattice of the data's samples. */
  lattice: [number, number];
};

/** Of a body: metres, and by how much the axis is shorter, as a share. */
export interface Ellipsoid {
  semiMajor: number;
  flattening: number;
}

export interface Scene {
  /** Names the scene: another build has another one. */
  readonly id: string;
  readonly title: string;
  readonly crs: string;
  /**
   * `planar`: the scene's axes are the map's, metres; `geographic`: east, north and up at its origin; `globe`: those of the body as a whole
   * (ECEF), from its middle.
   */
  readonly frame: FrameKind;
  /** From the scene's axes to the earth's (ECEF), 16 numbers by columns; null of a planar scene. */
  readonly toEcef: readonly number[] | null;
  /** That latitude, longitude and height are of; null of a planar scene. */
  readonly ellipsoid: Readonly<Ellipsoid> | null;
  /** Box about the data, in the scene's axes, metres. */
  readonly bounds: { readonly low: Readonly<Vector>; readonly high: Readonly<Vector> };
  /** Lowest and highest ground, metres above the zero surface. */
  readonly heights: { readonly lowest: number; readonly highest: number };
  /**
   * What heights count from: the kind of surface, its name, the geoid by which the other height is known (empty: none), and by how much
   * `Place` may be off where it tells that one, metres; what the server answers is exact.
   */
  readonly vertical: { readonly above: ZeroSurface; readonly name: string; readonly geoid: string; readonly maxError: number };
  /** Samples of the data, eastward and northward. */
  readonly samples: readonly [number, number];
  /** Of a scene that changes in time, milliseconds since 1970. */
  readonly epochs: readonly number[];
  /** How far its ground moves at most from the first epoch to another, metres. */
  readonly maxMoved: number;
  readonly layers: { readonly relief: boolean; readonly imagery: boolean };
  readonly attributions: readonly string[];
  /** High and low points of the data that are known at once, in the scene's axes; of a globe none. */
  readonly landmarks: readonly Readonly<Vector>[];
  /** Whether each model of the scene's objects has an image. */
  readonly modelImages: readonly boolean[];
}

/** @internal */
export function sceneOf(welcome: Welcome, screen: Screen): Scene {
  const layers = [screen.layer('relief'), screen.layer('imagery')];
  return deepFrozen({
    id: welcome.scene_id.toString(16).padStart(16, '0'),
    title: welcome.title,
    crs: welcome.crs,
    frame: welcome.frame,
    toEcef: ecefOf(welcome.frame, screen),
    ellipsoid: ellipsoidOf(welcome.frame, screen),
    bounds: { low: welcome.low, high: welcome.high },
    heights: { lowest: welcome.lowest_m, highest: welcome.highest_m },
    vertical: { above: welcome.zero_surface, name: welcome.datum, geoid: welcome.geoid, maxError: welcome.undulation_error_m },
    samples: welcome.samples,
    epochs: welcome.epochs_ms,
    maxMoved: welcome.max_moved_m,
    layers: { relief: layers[0] !== null, imagery: layers[1] !== null },
    attributions: attributionsOf(layers),
    landmarks: welcome.landmarks,
    modelImages: welcome.model_has_image,
  });
}

function attributionsOf(layers: readonly (Layer | null)[]): string[] {
  return [...new Set(layers.map((layer) => layer?.attribution ?? '').filter((text) => text !== ''))];
}

function ellipsoidOf(kind: FrameKind, screen: Screen): Ellipsoid | null {
  const frame = screen.slopeFrame();
  return kind === 'planar' || !frame ? null : { semiMajor: frame.semi_major_m, flattening: 1 - Math.sqrt(1 - frame.eccentricity_squared) };
}

// Of a globe nothing; else east, north and up at the scene's origin, and the origin itself.
function ecefOf(kind: FrameKind, screen: Screen): number[] | null {
  if (kind === 'planar') return null;
  if (kind === 'globe') return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const frame = screen.slopeFrame(), origin = screen.mapPosition([0, 0, 0]);
  if (!frame || !origin) return null;
  const [latitude, longitude] = origin.across.map((degrees) => (degrees * Math.PI) / 180) as [number, number];
  const [s, c, sl, cl] = [Math.sin(latitude), Math.cos(latitude), Math.sin(longitude), Math.cos(longitude)];
  const e2 = frame.eccentricity_squared, across_m = frame.semi_major_m / Math.sqrt(1 - e2 * s * s);
  const ring_m = (across_m + origin.height_m) * c;
  return [
    -sl, cl, 0, 0,
    -s * cl, -s * sl, c, 0,
    c * cl, c * sl, s, 0,
    ring_m * cl, ring_m * sl, (across_m * (1 - e2) + origin.height_m) * s, 1,
  ];
}

function deepFrozen<T>(value: T): T {
  if (typeof value === 'object' && value !== null) {
    for (const part of Object.values(value)) deepFrozen(part);
    Object.freeze(value);
  }
  return value;
}

/** @internal A height of a scene by both surfaces, where the geoid lies so far above the ellipsoid. */
export function bothHeights(above: ZeroSurface, height: number, undulation: number | null): BothHeights {
  if (above === 'sea') return { aboveSea: height, aboveEllipsoid: undulation === null ? null : height + undulation };
  if (above === 'ellipsoid') return { aboveSea: undulation === null ? null : height - undulation, aboveEllipsoid: height };
  return { aboveSea: null, aboveEllipsoid: null };
}

/** @internal */
export function placeOf(at: MapPosition, kind: FrameKind, above: ZeroSurface): Place {
  const both = bothHeights(above, at.height_m, at.undulation_m);
  const rest = { ...both, height: at.height_m, ground: at.ground_m, slope: at.slope_rad, up: at.up, lattice: at.lattice };
  const [northward, eastward] = at.across;
  return kind !== 'planar' ? { lat: northward, lon: eastward, ...rest } : { northing: northward, easting: eastward, ...rest };
}
