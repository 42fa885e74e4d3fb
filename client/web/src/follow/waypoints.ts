// A smooth way of the camera through places where it has been, and a tour of these as a file.
import type { MapPoint, Pose, Vector } from '@foreland/client';
import { basisAt, type UpAt } from './basis';
import { poseTowards, type Course } from './camera_path';
import { durationOf, flightOf, pointAt, type Flight } from './flight';

// Where the camera was, and where it looked.
export interface Waypoint {
  eye: Vector;
  height_m: number; // of the eye, above the scene's zero surface
  heading: number; // radians, clockwise from north
  pitch: number; // radians, positive looks up
}

export interface Way {
  flight: Flight; // of the eye
  looks: Flight; // heading, pitch and nothing, as points
}

const kLeastWay = 0.3; // of the mean one: the least that a turn on the spot counts

// Through all of them, two at least, in so many seconds; at an even speed, but for turns on the spot.
export function wayThrough(waypoints: readonly Waypoint[], seconds: number): Way {
  const ways = waypoints.slice(1).map(({ eye }, i) => Math.hypot(...eye.map((v, k) => v - waypoints[i]!.eye[k]!)));
  const mean = Math.max(ways.reduce((sum, way) => sum + way, 0) / ways.length, 1e-3), counts = ways.map((way) => Math.max(way, kLeastWay * mean));
  const whole = counts.reduce((sum, count) => sum + count, 0), times = [0];
  for (const count of counts) times.push(times[times.length - 1]! + (seconds * count) / whole);
  const headings = unwound(waypoints.map(({ heading }) => heading));
  const looks = waypoints.map(({ pitch }, i): Vector => [headings[i]!, pitch, 0]);
  return {
    flight: flightOf(times, waypoints.map(({ eye }) => eye), waypoints.map(({ height_m }) => height_m)),
    looks: flightOf(times, looks, looks.map(() => 0)),
  };
}

// Each heading by whole turns nearest to the one before.
function unwound(headings: readonly number[]): number[] {
  const out: number[] = [];
  for (const heading of headings) {
    const before = out[out.length - 1] ?? heading;
    out.push(heading - 2 * Math.PI * Math.round((heading - before) / (2 * Math.PI)));
  }
  return out;
}

export function courseOfWay({ flight, looks }: Way, step_s: number, upAt: UpAt): Course {
  const count = Math.max(Math.ceil(durationOf(flight) / step_s - 1e-9) + 1, 2), eyes: Vector[] = [], targets: Vector[] = [];
  for (let i = 0; i < count; ++i) {
    const eye = pointAt(flight, i * step_s), [heading, pitch] = pointAt(looks, i * step_s);
    eyes.push(eye);
    targets.push(ahead(eye, heading, pitch, upAt));
  }
  return { eyes, targets, step_s };
}

export function poseAt({ eye, heading, pitch }: Waypoint, upAt: UpAt): Pose {
  return poseTowards(eye, ahead(eye, heading, pitch, upAt), upAt(eye));
}

function ahead(eye: Vector, heading: number, pitch: number, upAt: UpAt): Vector {
  const [east, north, up] = basisAt(eye, upAt), level = Math.cos(pitch);
  return eye.map((v, k) => v + 100 * (level * (Math.sin(heading) * east[k]! + Math.cos(heading) * north[k]!) + Math.sin(pitch) * up[k]!)) as Vector;
}

// A place of the earth or of the map, and where the camera looks there.
export interface TourPlace {
  place: MapPoint;
  height_m: number; // above the sea, where the scene knows that
  heading_deg: number;
  pitch_deg: number;
}

// What a file of a tour has: its waypoints, and the way between them at even steps, for programs that fly tracks.
export interface Tour {
  name: string;
  seconds: number;
  waypoints: TourPlace[];
  way: { place: MapPoint; height_m: number; time_s: number }[];
  crs: string; // of a scene whose data are projected
}

const numbersOf = (place: MapPoint): [number, number] => ('lat' in place ? [place.lon, place.lat] : [place.easting, place.northing]);
const timeText = (time_s: number): string => new Date(1000 * time_s).toISOString();

// GeoJSON, with times from 1970 on; `foreland fly --track` flies it, and the page reads the waypoints again.
export function tourJson({ name, seconds, waypoints, way, crs }: Tour): string {
  const places = waypoints.map(({ place, height_m, heading_deg, pitch_deg }) => ({ at: [...numbersOf(place), height_m], heading_deg, pitch_deg }));
  const properties = { name, foreland_tour: { seconds, waypoints: places }, coordTimes: way.map(({ time_s }) => timeText(time_s)) };
  const geometry = { type: 'LineString', coordinates: way.map(({ place, height_m }) => [...numbersOf(place), height_m]) };
  const named = 'lat' in waypoints[0]!.place ? {} : { crs: { type: 'name', properties: { name: crs } } };
  return `${JSON.stringify({ type: 'FeatureCollection', ...named, features: [{ type: 'Feature', properties, geometry }] })}\n`;
}

// A tour of Google Earth's, and the way as a track, which `foreland fly --track` flies. For places of the earth.
export function tourKml({ name, waypoints, way }: Tour, times_s: readonly number[]): string {
  const flights = waypoints.map(({ place, height_m, heading_deg, pitch_deg }, i) => {
    const [lon, lat] = numbersOf(place), seconds = i === 0 ? 0.1 : times_s[i]! - times_s[i - 1]!;
    return `<gx:FlyTo><gx:duration>${seconds.toFixed(2)}</gx:duration><gx:flyToMode>${i === 0 ? 'bounce' : 'smooth'}</gx:flyToMode><Camera><longitude>${lon}</longitude><latitude>${lat}</latitude><altitude>${height_m.toFixed(2)}</altitude>`
      + `<heading>${((heading_deg % 360) + 360) % 360}</heading><tilt>${90 + pitch_deg}</tilt><roll>0</roll><altitudeMode>absolute</altitudeMode></Camera></gx:FlyTo>`;
  });
  const whens = way.map(({ time_s }) => `<when>${timeText(time_s)}</when>`), coordinates = way.map(({ place, height_m }) => `<gx:coord>${numbersOf(place).join(' ')} ${height_m.toFixed(2)}</gx:coord>`);
  return `<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document><name>${escaped(name)}</name>\n`
    + `<gx:Tour><name>${escaped(name)}</name><gx:Playlist>\n${flights.join('\n')}\n</gx:Playlist></gx:Tour>\n`
    + `<Placemark><name>${escaped(name)}</name><gx:Track><altitudeMode>absolute</altitudeMode>\n${whens.join('\n')}\n${coordinates.join('\n')}\n</gx:Track></Placemark></Document></kml>\n`;
}
function escaped(text: string): string {
  return text.replaceAll('&', '&amp;').replaceAll('<', '&lt;');
}

// The waypoints of a tour's file; null: it is none.
export function tourIn(json: unknown): Pick<Tour, 'seconds' | 'waypoints'> | null {
  const found = (json as { features?: { properties?: { foreland_tour?: { seconds: unknown; waypoints: unknown } } }[] } | null)?.features?.[0]?.properties?.foreland_tour;
  if (!found || !Array.isArray(found.waypoints) || typeof found.seconds !== 'number') return null;
  const is_lonlat = !('crs' in (json as object));
  const waypoints = found.waypoints.map((point: { at?: unknown; heading_deg?: unknown; pitch_deg?: unknown } | null): TourPlace => {
    const numbers = [...(Array.isArray(point?.at) ? point.at : []), point?.heading_deg, point?.pitch_deg];
    if (numbers.length !== 5 || !numbers.every((v): v is number => typeof v === 'number' && Number.isFinite(v))) throw new Error('A waypoint of the tour has no place, height, heading and pitch.');
    const [x, y, height_m, heading_deg, pitch_deg] = numbers as [number, number, number, number, number];
    return { place: is_lonlat ? { lon: x, lat: y } : { easting: x, northing: y }, height_m, heading_deg, pitch_deg };
  });
  if (waypoints.length < 2 || waypoints.length > 10_000 || !(found.seconds > 0 && found.seconds < 1e6)) throw new Error('The tour has no two waypoints, or no time for them.');
  return { seconds: found.seconds, waypoints };
}
