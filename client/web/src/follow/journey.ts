// What can be followed: a flight through the scene, and the camera's path along it for each seat. A track becomes one over the exact ground.
import type { MapPoint, Terrain, Vector } from '@foreland/client';
import { upIn } from './basis';
import { courseOf, liftsOf, posesOf, spread, type CameraPath, type Seat } from './camera_path';
import { flightOf, type Flight } from './flight';
import type { Track } from './track';

export interface Journey {
  name: string;
  notes: readonly string[];
  flight: Flight;
  begin_ms: number | null; // since 1970, where it is known
  seats: readonly Seat[]; // that it can be seen from; without any it has a path of its own
  pathOf(seat: Seat, speed: number): Promise<CameraPath>;
}

const kLeast_m = 2; // of an aircraft, above the ground
const kCameraLeast_m: Record<Seat, number> = { chase: 20, cockpit: 10 };
const kUsual_m = 50; // above the ground, of a track without heights
const kAtOnce = 65_536; // heights in a question
const kAskedPoses = 8000; // of a camera's path, at most

export async function journeyOf(terrain: Terrain, track: Track): Promise<Journey> {
  const { name } = track, notes = [...track.notes];
  const fixes = track.fixes[0]!.height_m === null ? densified(track.fixes) : track.fixes;
  const ground = await groundAt(terrain, fixes.map(({ place }) => place));
  const beyond = ground.filter((height) => !Number.isFinite(height)).length;
  if (beyond === ground.length) throw new Error(`${name} does not cross the scene's data.`);
  if (beyond > 0) notes.push(`${beyond.toLocaleString('en')} of ${ground.length.toLocaleString('en')} places lie beyond the scene's data.`);
  if (track.fixes[0]!.height_m === null) notes.push(`${name} has no heights: it is flown ${kUsual_m} m above the ground.`);
  let lifted = 0;
  const heights = fixes.map(({ place, height_m }, i) => {
    const over = Number.isFinite(ground[i]) ? ground[i]! : 0;
    if (height_m === null) return over + kUsual_m;
    const height = height_m + zeroAboveSea(terrain, place);
    if (height >= over + kLeast_m) return height;
    ++lifted;
    return over + kLeast_m;
  });
  if (lifted > 0) notes.push(`${lifted.toLocaleString('en')} of ${fixes.length.toLocaleString('en')} places were below the ground, and are lifted above it.`);
  const points = fixes.map(({ place }, i) => terrain.toScene({ ...place, height: heights[i]! }));
  const flight = flightOf(fixes.map(({ time_s }) => time_s), points, heights);
  return { name, notes, flight, begin_ms: track.begin_ms, seats: ['chase', 'cockpit'], pathOf: (seat, speed) => pathAlong(terrain, flight, seat, speed) };
}

// How far the scene's zero surface is below the sea's level there: tracks count from the sea.
function zeroAboveSea(terrain: Terrain, place: MapPoint): number {
  const at = terrain.place(terrain.toScene({ ...place, height: 0 }));
  return at?.aboveSea == null ? 0 : -at.aboveSea;
}

// Places in between, so that a track without heights follows the ground.
function densified(fixes: Track['fixes']): Track['fixes'] {
  const last_s = fixes[fixes.length - 1]!.time_s, count = Math.min(Math.max(Math.ceil(last_s), fixes.length), 4000);
  let at = 1;
  return Array.from({ length: count + 1 }, (_, i) => {
    const time_s = (last_s * i) / count;
    while (at + 1 < fixes.length && fixes[at]!.time_s < time_s) ++at;
    const [a, b] = [fixes[at - 1]!, fixes[at]!], share = (time_s - a.time_s) / (b.time_s - a.time_s);
    return { time_s, height_m: null, place: between(a.place, b.place, share) };
  });
}
function between(a: MapPoint, b: MapPoint, share: number): MapPoint {
  if ('lat' in a && 'lat' in b) return { lon: a.lon + share * (b.lon - a.lon), lat: a.lat + share * (b.lat - a.lat) };
  if ('easting' in a && 'easting' in b) return { easting: a.easting + share * (b.easting - a.easting), northing: a.northing + share * (b.northing - a.northing) };
  return a;
}

async function pathAlong(terrain: Terrain, flight: Flight, seat: Seat, speed: number): Promise<CameraPath> {
  const upAt = upIn(terrain.scene), course = courseOf(flight, seat, speed, upAt), count = course.eyes.length;
  return posesOf(course, seat, await liftsAlong(terrain, course.eyes, kCameraLeast_m[seat], speed / course.step_s, count), upAt);
}

// By how much each of the eyes is lifted, so that it is above the exact ground.
async function liftsAlong(terrain: Terrain, eyes: readonly Vector[], least_m: number, steps_in_s: number, count: number): Promise<number[]> {
  const stride = Math.max(1, Math.floor(count / kAskedPoses));
  const asked = eyes.filter((_, i) => i % stride === 0 || i === count - 1).map((eye) => terrain.place(eye)!);
  const ground = await groundAt(terrain, asked);
  const lifts = asked.map(({ height }, i) => (Number.isFinite(ground[i]) ? Math.max(0, ground[i]! + least_m - height) : 0));
  return spread(liftsOf(lifts, Math.max(1, Math.round(steps_in_s / stride))), stride, count);
}

async function groundAt(terrain: Terrain, places: readonly MapPoint[]): Promise<number[]> {
  const out: number[] = [];
  for (let begin = 0; begin < places.length; begin += kAtOnce) out.push(...(await terrain.heights(places.slice(begin, begin + kAtOnce))));
  return out;
}
