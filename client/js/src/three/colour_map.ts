// Colours for heights: GMT's colour palette tables (.cpt), as GMT and others publish them. Read are lines of two heights with a colour
// each, as r g b, r/g/b, #rrggbb, a grey or a name; B, F and N for what lies below, above and nowhere; HSV as h-s-v or by COLOR_MODEL;
// RANGE and HINGE, by which normalised tables name their heights; and labels after a semicolon. A file that has anything else is
// refused by its line. Pure.

/** Red, green and blue, 0 to 255. */
export type Rgb = readonly [number, number, number]; // 0 to 255

interface Slice {
  from: number;
  to: number;
  low: Rgb;
  high: Rgb;
}

/** Colours for heights, as a colour palette table has them. */
export interface ColourMap {
  name: string;
  slices: Slice[]; // ascending, without overlap
  below: Rgb;
  above: Rgb;
  nowhere: Rgb; // between slices
  is_normalised: boolean; // heights from 0 to 1, for any scene
}

const kMaxLines = 20_000;
const kNames: Record<string, Rgb> = {
  black: [0, 0, 0], white: [255, 255, 255], red: [255, 0, 0], green: [0, 255, 0], blue: [0, 0, 255], yellow: [255, 255, 0],
  cyan: [0, 255, 255], magenta: [255, 0, 255], gray: [190, 190, 190], grey: [190, 190, 190], brown: [165, 42, 42], orange: [255, 165, 0],
  purple: [160, 32, 240], pink: [255, 192, 203], darkgreen: [0, 100, 0], darkblue: [0, 0, 139], darkred: [139, 0, 0],
  lightgreen: [144, 238, 144], lightblue: [173, 216, 230], tan: [210, 180, 140], gold: [255, 215, 0], navy: [0, 0, 128],
};

class Refused extends Error {}

function numberOf(word: string | undefined, what: string): number {
  const value = Number(word);
  if (word === undefined || word === '' || !Number.isFinite(value)) throw new Refused(`${what} is to be a number, not "${word ?? ''}"`);
  return value;
}

function part(word: string | undefined, most: number, what: string): number {
  const value = numberOf(word, what);
  if (value < 0 || value > most) throw new Refused(`${what} is to lie between 0 and ${most}, not ${value}`);
  return value;
}

function rgbOfHsv(h: number, s: number, v: number): Rgb {
  const channel = (n: number) => {
    const k = (n + h / 60) % 6;
    return 255 * (v - v * s * Math.max(0, Math.min(k, 4 - k, 1)));
  };
  return [channel(5), channel(3), channel(1)];
}

function hsvOf(words: readonly (string | undefined)[]): Rgb {
  return rgbOfHsv(part(words[0], 360, 'a hue'), part(words[1], 1, 'a saturation'), part(words[2], 1, 'a value'));
}

// The colour at the front of the words, which it takes away.
function takeColour(words: string[], is_hsv: boolean): Rgb {
  const word = words.shift();
  if (word === undefined) throw new Refused('a colour is missing');
  if (/^#[0-9a-f]{6}$/i.test(word)) return [1, 3, 5].map((i) => Number.parseInt(word.slice(i, i + 2), 16)) as unknown as Rgb;
  const named = kNames[word.toLowerCase()];
  if (named) return named;
  if (word.includes('/')) {
    const parts = word.split('/');
    if (parts.length !== 3) throw new Refused(`"${word}" is no colour: r/g/b has three numbers`);
    return parts.map((p) => part(p, 255, 'a colour')) as unknown as Rgb;
  }
  const hsv = word.match(/^([0-9.]+)-([0-9.]+)-([0-9.]+)$/);
  if (hsv) return hsvOf(hsv.slice(1));
  if (!/^[-+0-9.]/.test(word)) throw new Refused(`"${word}" is no colour that is known`);
  // A grey stands alone.
  if (words.length === 0 || /^[LUB]$/.test(words[0]!)) {
    const grey = part(word, 255, 'a grey');
    return [grey, grey, grey];
  }
  const three = [word, words.shift(), words.shift()];
  return is_hsv ? hsvOf(three) : (three.map((p) => part(p, 255, 'a colour')) as unknown as Rgb);
}

function takeSlice(words: string[], is_hsv: boolean): Slice {
  const from = numberOf(words.shift(), 'the first height');
  // Four words are a height and a grey each.
  const low = words.length === 3 && !/[#/a-z]/i.test(words.join('')) ? takeGrey(words) : takeColour(words, is_hsv);
  const to = numberOf(words.shift(), 'the second height');
  const high = takeColour(words, is_hsv);
  const [flag] = words;
  if (flag !== undefined && !/^[LUB]$/.test(flag)) throw new Refused(`"${flag}" is too much`);
  if (!(to > from)) throw new Refused(`the heights do not ascend: ${from}, ${to}`);
  return { from, to, low, high };
}
function takeGrey(words: string[]): Rgb {
  const grey = part(words.shift(), 255, 'a grey');
  return [grey, grey, grey];
}

interface Header {
  is_hsv: boolean;
  range: readonly [number, number] | null;
  hinge: number | null;
}

function readComment(line: string, header: Header): void {
  const model = line.match(/COLOR_MODEL\s*=\s*\+?(\w+)/i);
  if (model) {
    if (!/^(rgb|hsv)$/i.test(model[1]!)) throw new Refused(`colours of the model ${model[1]} cannot be read; write them as RGB or HSV`);
    header.is_hsv = /hsv/i.test(model[1]!);
  }
  const range = line.match(/^#\s*RANGE\s*=\s*(\S+?)\/(\S+)/i);
  if (range) header.range = [numberOf(range[1], 'the range'), numberOf(range[2], 'the range')];
  if (header.range && !(header.range[1] > header.range[0])) throw new Refused('the range does not ascend');
  const hinge = line.match(/^#\s*(?:SOFT_|HARD_)?HINGE\s*=?\s*(\S*)/i);
  if (hinge) header.hinge = hinge[1] === '' ? 0 : numberOf(hinge[1], 'the hinge');
}

// Of a normalised table: its heights below and above the hinge are stretched to either end of the range.
function stretchTo([low, high]: readonly [number, number], hinge: number | null, slices: Slice[]): Slice[] {
  const [first, last] = [slices[0]!.from, slices[slices.length - 1]!.to];
  const has_hinge = hinge !== null && first < hinge && last > hinge && low < hinge && high > hinge;
  const at = (z: number) => {
    if (!has_hinge) return low + ((z - first) / (last - first)) * (high - low);
    return z < hinge ? hinge + ((z - hinge) / (first - hinge)) * (low - hinge) : hinge + ((z - hinge) / (last - hinge)) * (high - hinge);
  };
  return slices.map((s) => ({ ...s, from: at(s.from), to: at(s.to) }));
}

/** Reads a colour palette table of GMT (.cpt). Throws an Error that names the file and the line. */
export function readColourMap(text: string, name: string): ColourMap {
  const header: Header = { is_hsv: false, range: null, hinge: null };
  const slices: Slice[] = [];
  const ends: Partial<Record<'B' | 'F' | 'N', Rgb>> = {};
  const lines = text.split(/\r?\n/);
  if (lines.length > kMaxLines) throw new Error(`${name}: more than ${kMaxLines} lines`);
  lines.forEach((line, i) => {
    try {
      if (/^\s*#(?![0-9a-f]{6}\b)/i.test(line)) return readComment(line, header);
      const words = line.split(';')[0]!.trim().split(/[\s,]+/).filter((w) => w !== '');
      if (words.length === 0) return;
      const end = words[0] as 'B' | 'F' | 'N';
      if (/^[BFN]$/.test(end)) {
        words.shift();
        ends[end] = takeColour(words, header.is_hsv);
        return;
      }
      const slice = takeSlice(words, header.is_hsv);
      const last = slices[slices.length - 1];
      if (last && slice.from < last.to) throw new Refused(`its heights begin at ${slice.from}, below the end of the line before, ${last.to}`);
      slices.push(slice);
    } catch (error) {
      throw error instanceof Refused ? new Error(`${name}, line ${i + 1}: ${error.message}`) : error;
    }
  });
  if (slices.length === 0) throw new Error(`${name} has no colours: a line has a height, a colour, a height and a colour`);
  const [first, last] = [slices[0]!, slices[slices.length - 1]!];
  const is_normalised = header.range === null && first.from === 0 && last.to === 1;
  return {
    name, is_normalised,
    slices: header.range ? stretchTo(header.range, header.hinge, slices) : slices,
    below: ends.B ?? first.low, above: ends.F ?? last.high, nowhere: ends.N ?? [128, 128, 128],
  };
}

/** The colour of a height. */
export function colourAt(map: ColourMap, z: number): Rgb {
  const { slices } = map;
  if (z < slices[0]!.from) return map.below;
  const last = slices[slices.length - 1]!;
  if (z > last.to) return map.above;
  let [low, high] = [0, slices.length - 1]; // the last slice that begins at z or below
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (slices[middle]!.from <= z) low = middle;
    else high = middle - 1;
  }
  const s = slices[low]!;
  if (z > s.to) return map.nowhere;
  const t = (z - s.from) / (s.to - s.from);
  return s.low.map((v, i) => v + t * (s.high[i]! - v)) as unknown as Rgb;
}

/** The map with its heights from `low` to `high`. */
export function stretched(map: ColourMap, low: number, high: number): ColourMap {
  return { ...map, is_normalised: false, slices: stretchTo([low, high], null, map.slices) };
}

const kTexels = 2048; // of baked tints

/** Colours over the heights from `low` to `high`, as the ground is drawn with them. */
export interface Tints {
  low: number;
  high: number;
  texels: Uint8Array<ArrayBuffer>; // RGBA, sRGB
}

/** A map's colours over a scene's ground. A normalised map is stretched over it. */
export function tintsOf(map: ColourMap, lowest_m: number, highest_m: number): Tints {
  const [low, high] = [lowest_m, Math.max(highest_m, lowest_m + 1e-3)];
  const over = map.is_normalised ? stretched(map, low, high) : map;
  const texels = new Uint8Array(4 * kTexels);
  for (let i = 0; i < kTexels; ++i) texels.set([...colourAt(over, low + ((i + 0.5) / kTexels) * (high - low)).map(Math.round), 255], 4 * i);
  return { low, high, texels };
}
