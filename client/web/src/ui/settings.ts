// What the user can set, and its initial values from the page's address: ?tour=survey&strategy=predict&tau=1&wireframe=1 ...
import { kBlends, kPredictors, kStrategies, type Blend, type Predictor, type Strategy } from '@foreland/client';
import { kGrounds, type Ground } from '@foreland/client/three';
import { kExaggerations } from '../draw/exaggeration';
import { readAt, type PlaceView } from '../globe/place_text';
import { kSunModes, type SunSettings } from './sun';

export const kTours = ['survey', 'canyon', 'spin', 'orbit'] as const;
export type Tour = (typeof kTours)[number];

export interface Settings extends SunSettings {
  strategy: Strategy;
  blend: Blend;
  predictor: Predictor | 'auto'; // auto: the known path on a tour, constant velocity otherwise
  tau_px: number;
  keyframe_ms: number;
  adaptive: boolean; // keyframes are as far apart as the section's changes allow, and not always keyframe_ms
  wireframe: boolean;
  relief: boolean; // ground is shaded by tiles of relief
  imagery: boolean;
  shadows: boolean; // that ground casts on ground, by relief
  ground: Ground;
  colours: string; // the colour map of ground by height
  snow_line: number; // from 0, the lowest ground, to 1, the highest
  change: number; // of the ground since the first epoch that has the strongest colours, as a share of the largest one
  contours: boolean;
  fog: boolean;
  sea: boolean; // of a globe that has one; else its floor is seen
  exaggeration: number; // of heights
  map: boolean; // a small one, in a corner
  labels: boolean; // names of an overlay's points are written over the ground
  occlusion: boolean; // leave out what ridges hide, if the server can
  frozen: boolean; // the section stays the one of the pose at which it was frozen
}

export interface Address {
  settings: Settings;
  tour: Tour | null;
  server: string; // ws://... or wss://...
  token: string | null; // for a server that asks for one
  view: number[] | null; // x, y, z in metres, heading, pitch in degrees
  at: PlaceView | null; // the same of a scene on the earth
  area: string | null; // of a large scene, that view or at is in: for the address of the first connection
  tells_clock: boolean; // the day or the hour of the sun
  cut: string | null; // as CutControl writes it
  overlays: string[]; // addresses of files that lie on the ground
  anisotropy: number | null; // of pictures; null: what the graphics card does cheaply
  sharpness: number; // most device pixels per page pixel
  tracks: readonly string[]; // addresses of files to lay on the ground and to follow
  is_recorded: boolean; // the flight, from its beginning on
}

// Whether keyframes adapt: a spline of several keyframes needs equal intervals.
export const mayAdapt = ({ blend }: Settings): boolean => blend === 'keyframe' || blend === 'geomorph';
export const adapts = (settings: Settings): boolean => settings.adaptive && mayAdapt(settings);

// The bounds of adaptive keyframes, as proto::kAdaptiveInterval has them.
export const kAdaptive_ms = { shortest: 100, longest: 1000 };

const kMaxOverlays = 20;

const kFov_rad = (55 * Math.PI) / 180;
export const kLens = { fov_rad: kFov_rad };

function oneOf<T extends string>(query: URLSearchParams, name: string, values: readonly T[], otherwise: T): T {
  const value = query.get(name);
  return values.includes(value as T) ? (value as T) : otherwise;
}
function numberIn(query: URLSearchParams, name: string, low: number, high: number, otherwise: number): number {
  const value = Number.parseFloat(query.get(name) ?? '');
  return Number.isFinite(value) ? Math.min(Math.max(value, low), high) : otherwise;
}
function flagIn(query: URLSearchParams, name: string, otherwise: boolean): boolean {
  return query.has(name) ? query.get(name) !== '0' : otherwise;
}

export function readSettings(query: URLSearchParams): Settings {
  const number = (name: string, low: number, high: number, otherwise: number) => numberIn(query, name, low, high, otherwise);
  const flag = (name: string, otherwise: boolean) => flagIn(query, name, otherwise);
  return {
    strategy: oneOf(query, 'strategy', kStrategies, 'predict'),
    blend: oneOf(query, 'blend', kBlends, 'keyframe'),
    predictor: oneOf(query, 'predictor', ['auto', ...kPredictors], 'auto'),
    tau_px: number('tau', 0.25, 16, 1),
    keyframe_ms: number('keyframe', 50, 2000, 200),
    adaptive: query.get('keyframe') === 'adaptive',
    wireframe: flag('wireframe', false),
    relief: flag('relief', true),
    imagery: flag('imagery', true),
    shadows: flag('shadows', false),
    ground: oneOf(query, 'ground', kGrounds, 'natural'),
    colours: query.get('colours') ?? 'atlas',
    snow_line: number('snow', 0, 1.1, 0.75),
    change: number('change', 1 / 64, 1, 1),
    sun: oneOf(query, 'sun', kSunModes, 'map'),
    sun_hour: number('hour', 0, 24, 10),
    sun_day: number('day', 1, 365, 172),
    sun_azimuth_deg: number('azimuth', 0, 360, 315),
    sun_height_deg: number('height', 0, 90, 36),
    contours: flag('contours', false),
    fog: flag('fog', true),
    sea: flag('sea', true),
    exaggeration: number('exaggeration', kExaggerations.least, kExaggerations.most, 1),
    map: flag('map', false),
    labels: flag('labels', true),
    occlusion: flag('occlusion', true),
    frozen: false,
  };
}

// By which names the address has settings.
const kNames: Partial<Record<keyof Settings, string>> = {
  strategy: 'strategy', blend: 'blend', predictor: 'predictor', tau_px: 'tau', wireframe: 'wireframe', relief: 'relief', imagery: 'imagery', shadows: 'shadows', ground: 'ground',
  colours: 'colours', snow_line: 'snow', change: 'change', sun: 'sun', sun_hour: 'hour', sun_day: 'day', sun_azimuth_deg: 'azimuth', sun_height_deg: 'height', contours: 'contours',
  fog: 'fog', sea: 'sea', labels: 'labels', map: 'map', exaggeration: 'exaggeration', occlusion: 'occlusion',
};
const kUsual = readSettings(new URLSearchParams());

// Whatever is not as usual. Reading what it writes gives the same settings.
export function writeSettings(query: URLSearchParams, settings: Settings): void {
  const set = (name: string, text: string | null) => (text === null ? query.delete(name) : query.set(name, text));
  for (const [key, name] of Object.entries(kNames) as [keyof Settings, string][]) {
    const value = settings[key];
    set(name, value === kUsual[key] ? null : typeof value === 'boolean' ? String(Number(value)) : typeof value === 'number' ? String(Number(value.toFixed(4))) : value);
  }
  set('keyframe', settings.adaptive ? 'adaptive' : settings.keyframe_ms === kUsual.keyframe_ms ? null : String(settings.keyframe_ms));
}

const kArea = /^\d{1,9}$/;

// `server` is as serverAddress() gives it.
export function readAddress(location: Location, server: string): Address {
  const query = new URLSearchParams(location.search), tour = query.get('tour') as Tour | null;
  // In the part of the address that is not sent with the page's own requests: #token=...
  const token = new URLSearchParams(location.hash.slice(1)).get('token');
  const view = query.get('view')?.split(',').map(Number);
  return {
    settings: readSettings(query),
    tour: tour !== null && kTours.includes(tour) ? tour : null,
    server,
    token,
    view: view?.length === 5 && view.every(Number.isFinite) ? view : null,
    at: readAt(query.get('at')),
    area: (query.has('view') || query.has('at')) && kArea.test(query.get('area') ?? '') ? query.get('area') : null,
    tells_clock: query.has('day') || query.has('hour'),
    cut: query.get('cut'),
    overlays: query.getAll('overlay').slice(0, kMaxOverlays),
    anisotropy: query.has('anisotropy') ? numberIn(query, 'anisotropy', 1, 16, 1) : null,
    sharpness: numberIn(query, 'sharpness', 0.25, 3, 2),
    tracks: query.getAll('track'),
    is_recorded: flagIn(query, 'record', false),
  };
}
