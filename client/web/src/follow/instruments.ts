// What a flight's instruments say, in words.
import type { Units } from '../measure/units';

export function speedText(speed_mps: number, units: Units): string {
  return units === 'metric' ? `${(speed_mps * 3.6).toFixed(0)} km/h` : `${(speed_mps * 2.236936).toFixed(0)} mph`;
}

export function climbText(climb_mps: number, units: Units): string {
  const value = units === 'metric' ? climb_mps.toFixed(1) : (climb_mps * 196.8504).toFixed(0);
  return `${Number(value) > 0 ? '+' : ''}${value.replace(/^-(0(\.0*)?)$/, '$1').replace('-', '\u2212')} ${units === 'metric' ? 'm/s' : 'ft/min'}`;
}

// m:ss, with hours where there are any.
export function clockText(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds)), two = (n: number) => String(n).padStart(2, '0');
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return hours > 0 ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}
