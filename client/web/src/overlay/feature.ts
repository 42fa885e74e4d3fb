// What is drawn on the ground: points, lines and areas with a style and what is known of them.

export interface FeatureStyle {
  stroke: Colour;
  stroke_opacity: number;
  stroke_px: number;
  fill: Colour;
  fill_opacity: number;
  marker: Colour;
  marker_px: number; // height of the mark of a point
  symbol: string; // on it: a letter, a number or a name of Maki; empty: none
}
export type Colour = readonly [red: number, green: number, blue: number]; // 0 to 1, as CSS has them

export interface Feature {
  kind: 'point' | 'line' | 'area';
  parts: Places[]; // of an area, rings; of a point, its places in one part
  style: FeatureStyle;
  name: string; // empty: none
  properties: Readonly<Record<string, string>>; // but those of style
}
// Longitude and latitude of each place in degrees, one after another; in a planar scene easting and northing, m.
export type Places = Float64Array<ArrayBuffer>;

// A feature on a scene's lattice, as it is drawn, and found where it is clicked.
export interface Laid {
  outline: Places[]; // lines
  rings: Places[]; // of an area; those of a globe's end at the sides of its faces, where there is no outline
}

export interface Overlay {
  name: string;
  features: Feature[];
  notes: string[]; // what was left out or guessed, in words
}

const kColour = /^#?([0-9a-f]{3}|[0-9a-f]{6})$/i;
const kMarker_px: Record<string, number> = { small: 22, medium: 30, large: 40 };
const kOfStyle = /^(stroke|fill|marker|icon|label)(-|$)|^(styleUrl|styleHash|styleMapHash|coordinateProperties|mixed)$/;

function colourOf(text: unknown, otherwise: string): Colour {
  const digits = (typeof text === 'string' && kColour.exec(text)?.[1]) || otherwise;
  const six = digits.length === 3 ? [...digits].map((digit) => digit + digit).join('') : digits;
  return [0, 2, 4].map((at) => Number.parseInt(six.slice(at, at + 2), 16) / 255) as [number, number, number];
}

function numberOf(value: unknown, low: number, high: number, otherwise: number): number {
  const number = typeof value === 'number' ? value : typeof value === 'string' ? Number.parseFloat(value) : NaN;
  return Number.isFinite(number) ? Math.min(Math.max(number, low), high) : otherwise;
}

// Of a feature's properties, by simplestyle 1.1; `icon-color` and `icon-scale` are what KML's icons become.
export function styleOf(properties: Readonly<Record<string, unknown>>): FeatureStyle {
  const { stroke, fill, 'marker-color': marker, 'marker-size': size, 'marker-symbol': symbol } = properties;
  return {
    stroke: colourOf(stroke, 'ffd23d'),
    stroke_opacity: numberOf(properties['stroke-opacity'], 0, 1, 1),
    stroke_px: numberOf(properties['stroke-width'], 0, 20, 3),
    fill: colourOf(fill ?? stroke, 'ffd23d'),
    fill_opacity: numberOf(properties['fill-opacity'], 0, 1, 0.3),
    marker: colourOf(marker ?? properties['icon-color'], 'e8703a'),
    marker_px: (typeof size === 'string' && kMarker_px[size]) || numberOf(properties['icon-scale'], 0.6, 1.5, 1) * kMarker_px.medium!,
    symbol: typeof symbol === 'string' || typeof symbol === 'number' ? String(symbol).slice(0, 40) : '',
  };
}

export function isOfStyle(property: string): boolean {
  return kOfStyle.test(property);
}
