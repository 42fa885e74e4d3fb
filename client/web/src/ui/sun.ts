// Where the sun is: as maps are lit by custom, by the time of day and the date where a scene is on the earth, or as chosen. Over a globe: as
// maps would be lit where the camera is, by date and hour (UTC), or as chosen where the camera is.
import type { Scene } from '@foreland/client';
import * as THREE from 'three';
import { sunOverEarth } from '../globe/sun_position';
import { basisAt, kAxis } from './camera';

export const kSunModes = ['map', 'clock', 'free'] as const;
export type SunMode = (typeof kSunModes)[number];

export interface SunSettings {
  sun: SunMode;
  sun_hour: number; // mean solar time at the scene's origin; of a globe UTC
  sun_day: number; // of the year, from 1
  sun_azimuth_deg: number; // clockwise from north
  sun_height_deg: number; // above the horizon
}

export type Direction = [number, number, number]; // unit, in the scene's axes

const kRadians = Math.PI / 180;
const kMap: Direction = towards(-45, 36.1);

export function towards(azimuth_deg: number, height_deg: number): Direction {
  const [azimuth, height] = [azimuth_deg * kRadians, height_deg * kRadians];
  return [Math.sin(azimuth) * Math.cos(height), Math.cos(azimuth) * Math.cos(height), Math.sin(height)];
}

// Declination of the sun, radians, and by how much solar time is ahead of mean solar time, hours: Spencer's series (1971), to about
// 0.0006 radians and half a minute.
export function sunOf(day: number, hour: number): { declination: number; ahead_h: number } {
  const g = (2 * Math.PI * (day - 1 + (hour - 12) / 24)) / 365;
  const [c, s, c2, s2] = [Math.cos(g), Math.sin(g), Math.cos(2 * g), Math.sin(2 * g)];
  const declination = 0.006918 - 0.399912 * c + 0.070257 * s - 0.006758 * c2 + 0.000907 * s2 - 0.002697 * Math.cos(3 * g) + 0.00148 * Math.sin(3 * g);
  const minutes = 229.18 * (0.000075 + 0.001868 * c - 0.032077 * s - 0.014615 * c2 - 0.040849 * s2);
  return { declination, ahead_h: minutes / 60 };
}

// Seen from the scene's origin; the same direction holds everywhere, for the sun is far.
export function sunByClock(day: number, hour: number, origin_latitude: number): Direction {
  const { declination, ahead_h } = sunOf(day, hour);
  const angle = (hour + ahead_h - 12) * 15 * kRadians;
  const [x, y, z] = [Math.cos(declination) * Math.cos(angle), -Math.cos(declination) * Math.sin(angle), Math.sin(declination)];
  const [s, c] = [Math.sin(origin_latitude), Math.cos(origin_latitude)];
  return [y, c * z - s * x, s * z + c * x];
}

// Of a camera over a globe, with the ellipsoid's normal.
export function sunOverGlobe(settings: SunSettings, up: THREE.Vector3): Direction {
  if (settings.sun === 'clock') return sunOverEarth(settings.sun_day, settings.sun_hour);
  const local = settings.sun === 'free' ? towards(settings.sun_azimuth_deg, settings.sun_height_deg) : kMap;
  const axes = basisAt(up, kAxis);
  return new THREE.Vector3().addScaledVector(axes[0], local[0]).addScaledVector(axes[1], local[1]).addScaledVector(axes[2], local[2]).toArray();
}

export function sunDirection(settings: SunSettings, scene: Scene | null): Direction {
  const up = scene?.toEcef?.slice(8, 11); // at the scene's origin, in the earth's axes
  if (settings.sun === 'free' || (settings.sun === 'clock' && !up)) return towards(settings.sun_azimuth_deg, settings.sun_height_deg);
  return settings.sun === 'clock' ? sunByClock(settings.sun_day, settings.sun_hour, Math.asin(up![2]!)) : kMap;
}
