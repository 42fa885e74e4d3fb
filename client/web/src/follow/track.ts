// Recorded tracks: the lines of a file of features, as GeoJSON, with the times and heights of their places. Whatever is in them is a
// stranger's; an Error says in words what is wrong.
import type { MapPoint } from '@foreland/client';

const kMaxFixes = 400_000;
const kSpeed_mps = 10; // of a track without times, as `foreland fly` has it
const kEarth_m = 6_371_000;

export interface Fix {
  time_s: number; // since the first one; strictly ascending
  place: MapPoint;
  height_m: number | null; // as recorded: usually above the sea
}

export interface Track {
  name: string;
  fixes: Fix[]; // two at least; all have a height, or none has
  begin_ms: number | null; // of the first fix, since 1970; null: the file has no times
  notes: string[]; // what was left out or assumed, in words
}

// How the file's numbers are places of the scene.
export interface TrackMap {
  is_degrees: boolean; // longitude and latitude, or metres of a map
  toPlace(x: number, y: number): MapPoint;
}

type Json = Record<string, unknown>;
const isObject = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);
const listOf = (value: unknown): readonly unknown[] => (Array.isArray(value) ? value : []);

interface RawFix {
  x: number;
  y: number;
  height_m: number | null;
  time_ms: number | null;
}

// All lines, one after another. Times are those of `coordTimes` or `coordinateProperties.times`, as the parsers of GPX and KML write them.
export function trackOf(name: string, json: unknown, map: TrackMap): Track {
  const raw = linesIn(json);
  if (raw.length > kMaxFixes) throw new Error(`${name} has more than ${kMaxFixes.toLocaleString('en')} places.`);
  if (raw.length < 2) throw new Error(`${name} has no track: no line of two places at least.`);
  const notes: string[] = [];
  const fixes = withHeights(timed(name, raw, map, notes));
  const first = raw.find(({ time_ms }) => time_ms !== null)?.time_ms ?? null;
  return { name, fixes, begin_ms: first, notes };
}

// Whether a file of features has times, so that it is a track and no mere line.
export function hasTimes(json: unknown): boolean {
  return linesIn(json).some(({ time_ms }) => time_ms !== null);
}

function linesIn(json: unknown): RawFix[] {
  if (!isObject(json)) return [];
  if (json.type === 'FeatureCollection') return listOf(json.features).flatMap(linesIn);
  if (json.type !== 'Feature' || !isObject(json.geometry)) return [];
  const { type, coordinates } = json.geometry, properties = isObject(json.properties) ? json.properties : {};
  const detail = isObject(properties.coordinateProperties) ? properties.coordinateProperties.times : undefined;
  const times = listOf(detail ?? properties.coordTimes);
  if (type === 'LineString') return lineOf(coordinates, times);
  if (type === 'MultiLineString') return listOf(coordinates).flatMap((line, i) => lineOf(line, listOf(times[i])));
  return [];
}

function lineOf(coordinates: unknown, times: readonly unknown[]): RawFix[] {
  return listOf(coordinates).flatMap((at, i): RawFix[] => {
    const [x, y, z] = listOf(at);
    if (typeof x !== 'number' || typeof y !== 'number' || !Number.isFinite(x) || !Number.isFinite(y)) return [];
    const time_ms = typeof times[i] === 'string' ? Date.parse(times[i]) : NaN;
    return [{ x, y, height_m: typeof z === 'number' && Math.abs(z) < 1e5 ? z : null, time_ms: Number.isFinite(time_ms) ? time_ms : null }];
  });
}

// With times that ascend. Where none is written the track goes at a constant speed.
function timed(name: string, raw: readonly RawFix[], { is_degrees, toPlace }: TrackMap, notes: string[]): Fix[] {
  const known = raw.filter(({ time_ms }) => time_ms !== null);
  const fixes: Fix[] = [];
  const add = ({ x, y, height_m }: RawFix, time_s: number) => fixes.push({ time_s, height_m, place: toPlace(x, y) });
  if (known.length < 2) {
    let along_m = 0;
    raw.forEach((fix, i) => {
      const way_m = i === 0 ? 0 : distance_m(raw[i - 1]!, fix, is_degrees);
      along_m += way_m;
      if (i === 0 || way_m > 0) add(fix, along_m / kSpeed_mps);
    });
    notes.push(`${name} has no times: it is flown at ${kSpeed_mps} m/s.`);
  } else {
    let last_ms = -Infinity;
    for (const fix of known) {
      if (fix.time_ms! <= last_ms) continue;
      last_ms = fix.time_ms!;
      add(fix, (last_ms - known[0]!.time_ms!) / 1000);
    }
    const left_out = raw.length - fixes.length;
    if (left_out > 0) notes.push(`${left_out.toLocaleString('en')} of ${raw.length.toLocaleString('en')} places have no time, or one that does not ascend, and were left out.`);
  }
  if (fixes.length < 2) throw new Error(`${name} has no track: it stays at one place, or its times do not ascend.`);
  return fixes;
}

// Near enough for a speed that is assumed.
function distance_m(a: RawFix, b: RawFix, is_degrees: boolean): number {
  if (!is_degrees) return Math.hypot(b.x - a.x, b.y - a.y);
  const radian = Math.PI / 180;
  return kEarth_m * radian * Math.hypot((b.x - a.x) * Math.cos(0.5 * (a.y + b.y) * radian), b.y - a.y);
}

// Heights that are missing lie between their neighbours'.
function withHeights(fixes: Fix[]): Fix[] {
  const known = fixes.flatMap(({ height_m }, i) => (height_m === null ? [] : [i]));
  if (known.length === 0) return fixes;
  let at = 0;
  fixes.forEach((fix, i) => {
    while (at + 1 < known.length && known[at + 1]! <= i) ++at;
    if (fix.height_m !== null) return;
    const [a, b] = [fixes[known[at]!]!, fixes[known[Math.min(at + 1, known.length - 1)]!]!];
    const share = b.time_s > a.time_s ? Math.min(Math.max((fix.time_s - a.time_s) / (b.time_s - a.time_s), 0), 1) : 0;
    fix.height_m = a.height_m! + share * (b.height_m! - a.height_m!);
  });
  return fixes;
}
