// What can be followed: a flight through the scene, and the camera's path along it for each seat. A track becomes one over the exact ground.
import type { MapPoint, Terrain, Vector } from '@foreland/client';
import { upIn } from './basis';
import { courseOf, liftsOf, posesOf, spread, stepOf, type CameraPath, type Seat } from './camera_path';
import { durationOf, flightOf, heightAt, pointAt, type Flight } from './flight';
import type { Track } from './track';
import { courseOfWay, wayThrough, type Tour, type TourPlace, type Waypoint } from './waypoints';

export interface Journey {
  name: string;
  notes: readonly string[];
  flight: Flight;
  begin_ms: number | null; // since 1970, where it is known
  seats: readonly Seat[]; // that it can be seen from; without any it has a path of its own
  pathOf(seat: Seat, speed: number): Promise<CameraPath>;
}

const kLeast_m = 2; // of an aircraft, above the ground
const kCameraLeast_m: Record<Seat | 'own', number> = { chase: 20, cockpit: 10, own: 2 };
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

// Of the camera through waypoints.
export function journeyThrough(terrain: Terrain, name: string, waypoints: readonly Waypoint[], seconds: number): Journey {
  const way = wayThrough(waypoints, seconds), upAt = upIn(terrain.scene), { low, high } = terrain.scene.bounds;
  const least_m = Math.min(kCameraLeast_m.own, Math.hypot(high[0] - low[0], high[1] - low[1]) / 2000);
  return {
    name, notes: [], flight: way.flight, begin_ms: null, seats: [],
    pathOf: async (_, speed) => {
      const course = courseOfWay(way, stepOf(way.flight, speed), upAt);
      return posesOf(course, 'cockpit', await liftsAlong(terrain, course.eyes, least_m, speed / course.step_s), upAt);
    },
  };
}

const kWayStep_s = 0.5;

// As a file has it, with heights above the sea where the scene knows these.
export function tourOf(terrain: Terrain, name: string, waypoints: readonly Waypoint[], seconds: number): { tour: Tour; times_s: readonly number[] } {
  const { flight } = wayThrough(waypoints, seconds), degrees = (radians: number) => (radians * 180) / Math.PI;
  const placed = (point: Vector, height_m: number): { place: MapPoint; height_m: number } => {
    const place = mapPointAt(terrain, point);
    return { place, height_m: height_m - zeroAboveSea(terrain, place) };
  };
  const count = Math.ceil(seconds / kWayStep_s);
  return {
    times_s: [...flight.times_s],
    tour: {
      name, seconds, crs: terrain.scene.crs,
      waypoints: waypoints.map(({ eye, height_m, heading, pitch }) => ({ ...placed(eye, height_m), heading_deg: degrees(heading), pitch_deg: degrees(pitch) })),
      way: Array.from({ length: count + 1 }, (_, i) => ({ ...placed(pointAt(flight, (durationOf(flight) * i) / count), heightAt(flight, (durationOf(flight) * i) / count)), time_s: (durationOf(flight) * i) / count })),
    },
  };
}
export function waypointsOf(terrain: Terrain, places: readonly TourPlace[]): Waypoint[] {
  const radians = (degrees: number) => (degrees * Math.PI) / 180;
  return places.map(({ place, height_m, heading_deg, pitch_deg }) => {
    const height = height_m + zeroAboveSea(terrain, place);
    return { eye: terrain.toScene({ ...place, height }), height_m: height, heading: radians(heading_deg), pitch: radians(pitch_deg) };
  });
}
function mapPointAt(terrain: Terrain, point: Vector): MapPoint {
  const place = terrain.toGeodetic(point);
  return 'lat' in place ? { lon: place.lon, lat: place.lat } : { easting: place.easting, northing: place.northing };
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
  const upAt = upIn(terrain.scene), course = courseOf(flight, seat, speed, upAt);
  return posesOf(course, seat, await liftsAlong(terrain, course.eyes, kCameraLeast_m[seat], speed / course.step_s), upAt);
}

// By how much each of the eyes is lifted, so that it is above the exact ground.
async function liftsAlong(terrain: Terrain, eyes: readonly Vector[], least_m: number, steps_in_s: number): Promise<number[]> {
  const count = eyes.length;
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
