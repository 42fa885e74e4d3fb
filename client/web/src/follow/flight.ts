// A flight: a smooth curve in the scene through the fixes of a track. Speed and climb are the curve's own, so the speed integrates to its
// length, and the climb to the difference of heights.
import type { Vector } from '@foreland/client';

// Each fix, and how fast it is passed there.
export interface Flight {
  readonly times_s: Float64Array; // ascending, from 0
  readonly points: readonly Vector[];
  readonly heights_m: Float64Array; // above the scene's zero surface
  readonly tangents: readonly Vector[]; // m/s
  readonly climbs_mps: Float64Array;
}

export function flightOf(times_s: readonly number[], points: readonly Vector[], heights_m: readonly number[]): Flight {
  const times = Float64Array.from(times_s), heights = Float64Array.from(heights_m);
  return {
    times_s: times, points, heights_m: heights,
    tangents: points.map((_, i): Vector => [0, 1, 2].map((k) => slopeAt(times, (j) => points[j]![k]!, i)) as Vector),
    climbs_mps: heights.map((_, i) => slopeAt(times, (j) => heights[j]!, i)),
  };
}

export function durationOf({ times_s }: Flight): number {
  return times_s[times_s.length - 1]!;
}

// Of the parabola through a value and its neighbours.
function slopeAt(times: Float64Array, value: (i: number) => number, i: number): number {
  const last = times.length - 1;
  const chord = (a: number) => (value(a + 1) - value(a)) / (times[a + 1]! - times[a]!);
  if (i === 0) return chord(0);
  if (i === last) return chord(last - 1);
  const before_s = times[i]! - times[i - 1]!, after_s = times[i + 1]! - times[i]!;
  return (after_s * chord(i - 1) + before_s * chord(i)) / (before_s + after_s);
}

// The piece of the curve at a time, and how far into it.
function pieceAt({ times_s }: Flight, time_s: number): { i: number; u: number; h: number } {
  let [low, high] = [0, times_s.length - 2];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times_s[middle]! <= time_s) low = middle;
    else high = middle - 1;
  }
  const h = times_s[low + 1]! - times_s[low]!;
  return { i: low, h, u: Math.min(Math.max((time_s - times_s[low]!) / h, 0), 1) };
}

function valueOn(a: number, b: number, slope_a: number, slope_b: number, u: number, h: number): number {
  const v = 1 - u;
  return a * v * v * (1 + 2 * u) + b * u * u * (1 + 2 * v) + h * u * v * (slope_a * v - slope_b * u);
}
function slopeOn(a: number, b: number, slope_a: number, slope_b: number, u: number, h: number): number {
  return (6 * u * (1 - u) * (b - a)) / h + slope_a * (1 - u) * (1 - 3 * u) + slope_b * u * (3 * u - 2);
}

// Before its beginning and after its end the flight stands still.
export function pointAt(flight: Flight, time_s: number): Vector {
  const { i, u, h } = pieceAt(flight, time_s), { points, tangents } = flight;
  return [0, 1, 2].map((k) => valueOn(points[i]![k]!, points[i + 1]![k]!, tangents[i]![k]!, tangents[i + 1]![k]!, u, h)) as Vector;
}
export function velocityAt(flight: Flight, time_s: number): Vector {
  const { i, u, h } = pieceAt(flight, time_s), { points, tangents } = flight;
  return [0, 1, 2].map((k) => slopeOn(points[i]![k]!, points[i + 1]![k]!, tangents[i]![k]!, tangents[i + 1]![k]!, u, h)) as Vector;
}
export function speedAt(flight: Flight, time_s: number): number {
  return Math.hypot(...velocityAt(flight, time_s));
}
export function heightAt(flight: Flight, time_s: number): number {
  const { i, u, h } = pieceAt(flight, time_s), { heights_m, climbs_mps } = flight;
  return valueOn(heights_m[i]!, heights_m[i + 1]!, climbs_mps[i]!, climbs_mps[i + 1]!, u, h);
}
export function climbAt(flight: Flight, time_s: number): number {
  const { i, u, h } = pieceAt(flight, time_s), { heights_m, climbs_mps } = flight;
  return slopeOn(heights_m[i]!, heights_m[i + 1]!, climbs_mps[i]!, climbs_mps[i + 1]!, u, h);
}

// What instruments show: means over a while about a time, since recorders round to metres and seconds.
export function meanSpeedAt(flight: Flight, time_s: number, within_s: number): number {
  const [begin, end] = spanOf(flight, time_s, within_s), steps = 8;
  let length_m = 0, before = pointAt(flight, begin);
  for (let k = 1; k <= steps; ++k) {
    const next = pointAt(flight, begin + ((end - begin) * k) / steps);
    length_m += Math.hypot(...next.map((v, axis) => v - before[axis]!));
    before = next;
  }
  return length_m / (end - begin);
}
export function meanClimbAt(flight: Flight, time_s: number, within_s: number): number {
  const [begin, end] = spanOf(flight, time_s, within_s);
  return (heightAt(flight, end) - heightAt(flight, begin)) / (end - begin);
}
function spanOf(flight: Flight, time_s: number, within_s: number): [number, number] {
  const last = durationOf(flight), half = Math.min(0.5 * within_s, 0.5 * last);
  const middle = Math.min(Math.max(time_s, half), last - half);
  return [middle - half, middle + half];
}
