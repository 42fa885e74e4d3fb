// Views of the earth as text, for the page's address and for a search: latitude, longitude, height above the zero surface, heading and pitch.
import DMS from 'geographiclib-dms';

export interface PlaceView {
  lat: number; // degrees
  lon: number;
  height?: number; // metres
  heading?: number; // degrees
  pitch?: number;
}

// `at=` of the address; null for what is none.
export function readAt(text: string | null): PlaceView | null {
  const numbers = text?.split(',').map((part) => (part.trim() === '' ? NaN : Number(part))) ?? [];
  const [lat, lon, height, heading, pitch] = numbers;
  if (numbers.length < 2 || numbers.length > 5 || !numbers.every(Number.isFinite) || Math.abs(lat!) > 90 || Math.abs(lon!) > 540 || Math.abs(pitch ?? 0) > 90) return null;
  return { lat: lat!, lon: lon!, ...(height === undefined ? {} : { height }), ...(heading === undefined ? {} : { heading }), ...(pitch === undefined ? {} : { pitch }) };
}

// To a centimetre, and finer than what is seen of a millionth of a radian.
export function atText({ lat, lon, height }: { lat: number; lon: number; height: number }, { heading, pitch }: { heading: number; pitch: number }): string {
  const degrees = (radians: number) => (radians * 180) / Math.PI, turns = Math.round(heading / (2 * Math.PI));
  const numbers = [lat.toFixed(7), lon.toFixed(7), height.toFixed(2), degrees(heading - 2 * Math.PI * turns).toFixed(4), degrees(pitch).toFixed(4)];
  return numbers.map((number) => number.replace(/\.?0+$/, '').replace(/^-0$/, '0')).join(',');
}

// What people write for a place: 46.5 8.0, 46°30'N 8°E, 46.5N, 8E, 4000. The last one is a height in metres. Throws an Error that says what is wrong.
export function placeOf(text: string): PlaceView {
  const parts = text.trim().replace(/([NSEW])(?=[\s\d+-])/gi, '$1 ').split(/\s*[,;]\s*|\s+/).filter((part) => part !== '');
  if (parts.length < 2 || parts.length > 3) throw new Error('Write a latitude and a longitude: 46.5, 7.8 or 46\u00b030\u2032N 7\u00b048\u2032E; and a height in metres, if you like.');
  const { lat, lon } = DMS.DecodeLatLon(parts[0]!, parts[1]!), height = parts[2] === undefined ? undefined : Number.parseFloat(parts[2]);
  if (!Number.isFinite(lat) || !Number.isFinite(lon)) throw new Error('That is no latitude and longitude.');
  if (height !== undefined && !Number.isFinite(height)) throw new Error('The height is no number.');
  return { lat, lon, ...(height === undefined ? {} : { height }) };
}
