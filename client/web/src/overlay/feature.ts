// What is drawn on the ground: points, lines and areas with a style and what is known of them.
import type { MapPoint } from '@foreland/client';

export interface FeatureStyle {
  stroke: readonly [red: number, green: number, blue: number]; // 0 to 1, as CSS has them
  stroke_opacity: number;
  stroke_px: number;
  fill: readonly [red: number, green: number, blue: number];
  fill_opacity: number;
}

export interface Feature {
  kind: 'point' | 'line' | 'area';
  parts: MapPoint[][]; // of an area, rings; of a point, its places in one part
  style: FeatureStyle;
  name: string; // empty: none
  properties: Readonly<Record<string, string>>;
}

export interface Overlay {
  name: string;
  features: Feature[];
  notes: string[]; // what was left out, in words
}

const kColour = /^#?([0-9a-f]{3}|[0-9a-f]{6})$/i;

function colourOf(text: unknown, otherwise: string): FeatureStyle['stroke'] {
  const digits = (typeof text === 'string' && kColour.exec(text)?.[1]) || otherwise;
  const six = digits.length === 3 ? [...digits].map((digit) => digit + digit).join('') : digits;
  return [0, 2, 4].map((at) => Number.parseInt(six.slice(at, at + 2), 16) / 255) as [number, number, number];
}

function numberOf(value: unknown, low: number, high: number, otherwise: number): number {
  const number = typeof value === 'number' ? value : typeof value === 'string' ? Number.parseFloat(value) : NaN;
  return Number.isFinite(number) ? Math.min(Math.max(number, low), high) : otherwise;
}

// Of a feature's properties, by simplestyle 1.1.
export function styleOf(properties: Readonly<Record<string, unknown>>): FeatureStyle {
  return {
    stroke: colourOf(properties.stroke ?? properties['marker-color'], 'ffd23d'),
    stroke_opacity: numberOf(properties['stroke-opacity'], 0, 1, 1),
    stroke_px: numberOf(properties['stroke-width'], 0, 20, 3),
    fill: colourOf(properties.fill, 'ffd23d'),
    fill_opacity: numberOf(properties['fill-opacity'], 0, 1, 0.3),
  };
}
