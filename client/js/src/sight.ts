// Questions of what is seen, as a terrain's user asks them: places instead of positions on the lattice.
import type { Sight as CoreSight, Sights, Viewshed } from './core/sight.js';
import { kUsualRefraction } from './core/sight.js';
import { ForelandError } from './errors.js';
import type { MapPoint, Vector } from './scene.js';

export type { Viewshed };

const kMaxPairs = 4096; // of a question, and the numbers that a server takes: docs/PROTOCOL.md, section 19
const kMaxHeight_m = 1e6;
const kLongest_m = 1e7;
const kShortest_m = 1e-3;
const kEye_m = 1.7;

/** How lines of sight are asked for. */
export interface SightOptions {
  /** What the places' heights are above. Default `zero surface`, as everywhere in this package. */
  above?: 'ground' | 'zero surface';
  /** By which share of the earth's curvature light bends, 0 to 1. Default 1/7, as in usual air. In planar scenes 1 makes lines straight, in geographic ones 0. */
  refraction?: number;
  /** When, in scenes that change in time, milliseconds since 1970. Default: the last epoch. */
  sceneTime?: number;
}

/** A line of sight, in the scene's axes. */
export interface Sight {
  readonly from: Vector;
  readonly to: Vector;
  /** Whether `to` is seen from `from`. */
  readonly isSeen: boolean;
  /** Whether there is an answer: none where an end is to be above ground that the data do not have. */
  readonly isKnown: boolean;
  /** The first point that hides; null: none does. */
  readonly hit: Vector | null;
  /** Which object hides, by its number; null: the ground does, or nothing. */
  readonly object: number | null;
}

/** What a viewshed is asked with; lengths in metres. */
export interface ViewshedQuestion {
  /** Where the eye is; `height` is above the ground, 1.7 where it is not given. */
  from: MapPoint;
  /** How high above the ground what is looked at is. Default 0. */
  target?: number;
  radius: number;
  /** Width of a cell. A server answers for at most 4,194,304 of them. */
  cell: number;
  /** As of `SightOptions`. */
  refraction?: number;
  /** As of `SightOptions`. */
  sceneTime?: number;
  /** Aborting it ends the work, and rejects with its reason. */
  signal?: AbortSignal;
}

type LatticeOf = (place: MapPoint) => readonly [number, number];

function checked(name: string, value: number, low: number, high: number): number {
  if (value >= low && value <= high) return value;
  throw new ForelandError('argument', `${name} is ${value}.`, `Give a number from ${low} to ${high}.`);
}
function optional(refraction: number | undefined, sceneTime: number | undefined): { refraction: number; scene_ms?: number } {
  const bends = checked('The refraction', refraction ?? kUsualRefraction, 0, 1);
  return sceneTime === undefined ? { refraction: bends } : { refraction: bends, scene_ms: checked('The scene time', sceneTime, -8.64e15, 8.64e15) };
}

// The server, or the connection to it, gave no answer.
function unanswered(error: unknown): never {
  if (!(error instanceof Error) || error instanceof ForelandError || error.name === 'AbortError') throw error;
  throw new ForelandError('unanswered', error.message, 'Ask for less, or again once there is a connection.', { cause: error });
}

function sightOf({ from, to, hit, object, is_known }: CoreSight): Sight {
  return { from, to, isSeen: is_known && hit === null, isKnown: is_known, hit, object };
}

/** @internal Throws at once for what makes no sense: numbers out of range would end the session. */
export async function askVisible(sights: Sights, latticeOf: LatticeOf, pairs: readonly (readonly [MapPoint, MapPoint])[], options: SightOptions): Promise<Sight[]> {
  if (pairs.length > kMaxPairs) throw new ForelandError('argument', `${pairs.length} pairs are too many for one question.`, `Ask for at most ${kMaxPairs}.`);
  const more = optional(options.refraction, options.sceneTime);
  const pointOf = (place: MapPoint) => [...latticeOf(place), checked('A height', place.height ?? 0, -kMaxHeight_m, kMaxHeight_m)] as const;
  const ends = pairs.map(([from, to]) => [pointOf(from), pointOf(to)] as const);
  if (ends.length === 0) return [];
  const answers = await sights.visible({ pairs: ends, above: options.above ?? 'zero surface', ...more }).catch(unanswered);
  return answers.map(sightOf);
}

/** @internal */
export async function askViewshed(sights: Sights, latticeOf: LatticeOf, question: ViewshedQuestion, onProgress: (viewshed: Viewshed) => void): Promise<Viewshed> {
  const { from, signal } = question;
  const asked = {
    observer: latticeOf(from),
    observer_m: checked('The height of the eye', from.height ?? kEye_m, 0, kMaxHeight_m),
    target_m: checked('The height of what is looked at', question.target ?? 0, 0, kMaxHeight_m),
    radius_m: checked('The radius', question.radius, kShortest_m, kLongest_m),
    cell_m: checked('The width of a cell', question.cell, kShortest_m, kLongest_m),
    ...optional(question.refraction, question.sceneTime),
  };
  signal?.throwIfAborted();
  return sights.viewshed(asked, onProgress, signal).catch((error: unknown) => {
    signal?.throwIfAborted();
    return unanswered(error);
  });
}

/** @internal A listener that throws is reported, and stops nobody else. */
export function reported<T>(listener: (value: T) => void): (value: T) => void {
  return (value) => {
    try {
      listener(value);
    } catch (error) {
      console.error(error);
    }
  };
}
