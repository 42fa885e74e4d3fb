// Where the sun stands over the earth, and what a clock says of a time.
import { getPosition } from 'suncalc';

const kRadians = Math.PI / 180;

// In the earth's axes. The library tells where the sun is seen, lifted by the air: where it stands high, that is nothing.
export function sunOverEarth(day: number, hour: number, year = new Date().getUTCFullYear()): [number, number, number] {
  const longitude = 15 * (12 - hour), { azimuth, altitude } = getPosition(new Date(Date.UTC(year, 0, day) + 3600e3 * hour), 0, longitude);
  const [a, h] = [azimuth * kRadians, altitude * kRadians], [east, north, up] = [Math.sin(a) * Math.cos(h), Math.cos(a) * Math.cos(h), Math.sin(h)];
  const [s, c] = [Math.sin(longitude * kRadians), Math.cos(longitude * kRadians)];
  return [c * up - s * east, s * up + c * east, north];
}

// Day of the year and hour of a time, UTC.
export function clockOf(now: Date): { sun_day: number; sun_hour: number } {
  const day_ms = 86400e3, since_ms = now.getTime() - Date.UTC(now.getUTCFullYear(), 0, 1);
  return { sun_day: 1 + Math.floor(since_ms / day_ms), sun_hour: Math.round((since_ms % day_ms) / 36e3) / 100 };
}
