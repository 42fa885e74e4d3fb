// What a server tells of the sea of a globe, in a file beside the scene (docs/PROTOCOL.md, section 20). Pure.
import { ForelandError } from '../errors.js';

/** How far a geoid lies above the ellipsoid, on meridians and parallels; bilinear between them. */
export interface Undulations {
  /** Longitude and latitude of the south-western value, degrees. */
  first: readonly [number, number];
  /** Degrees eastward and northward to the next ones. */
  step: readonly [number, number];
  columns: number;
  rows: number;
  /** Row by row from the south. */
  metres: Float32Array<ArrayBuffer>;
  /** By how much they may be off the geoid's, metres. */
  maxError: number;
}

export interface Sea {
  /** Whether it is to be drawn, or only known. */
  isDrawn: boolean;
  /** Null where the scene knows no geoid: the sea is then at height 0. */
  undulations: Undulations | null;
}

const kHead = 64, kMostValues = 1 << 21, kMost_m = 1e4 + 1; // rounded

function refused(what: string): ForelandError {
  return new ForelandError('client', `The server's file of the sea cannot be read: ${what}.`, 'Use a page and a server of the same release.');
}

/** Reads `sea.bin`. Throws for bytes that are none. */
export function readSea(bytes: ArrayBuffer): Sea {
  if (bytes.byteLength < kHead) throw refused('it is too short');
  const view = new DataView(bytes), [drawn, columns, rows] = [0, 4, 8].map((at) => view.getUint32(at, true)) as [number, number, number];
  if (drawn > 1 || view.getUint32(12, true) !== 0) throw refused('it is of another version');
  if (columns === 0 && rows === 0) {
    if (bytes.byteLength !== kHead) throw refused('it has values of no grid');
    return { isDrawn: drawn === 1, undulations: null };
  }
  const [west, south, east_step, north_step, unit_m, maxError] = [16, 24, 32, 40, 48, 56].map((at) => view.getFloat64(at, true)) as [number, number, number, number, number, number];
  const isPositive = (value: number) => value > 0 && value < Infinity;
  if (columns < 2 || rows < 2 || columns * rows > kMostValues || ![east_step, north_step, unit_m].every(isPositive) || !(maxError >= 0 && maxError < Infinity) || !Number.isFinite(west) || !Number.isFinite(south))
    throw refused('its grid is none');
  return { isDrawn: drawn === 1, undulations: { first: [west, south], step: [east_step, north_step], columns, rows, metres: metresOf(new Uint8Array(bytes, kHead), columns, rows, unit_m), maxError } };
}

// Differences from what the values west, south and south-west foretell.
function metresOf(bytes: Uint8Array, columns: number, rows: number, unit_m: number): Float32Array<ArrayBuffer> {
  const metres = new Float32Array(columns * rows);
  let at = 0;
  const number = () => {
    let value = 0;
    for (let scale = 1; ; scale *= 128) {
      const byte = bytes[at++];
      if (byte === undefined || scale > 2 ** 28) throw refused('it ends too early');
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
  };
  let [before, row] = [new Int32Array(columns + 1), new Int32Array(columns + 1)];
  for (let y = 0; y < rows; ++y) {
    for (let x = 0; x < columns; ++x) {
      const code = number(), value = row[x]! + before[x + 1]! - before[x]! + (code % 2 === 0 ? code / 2 : -(code + 1) / 2);
      if (!(Math.abs(value * unit_m) <= kMost_m)) throw refused('an undulation is absurdly large');
      row[x + 1] = value;
      metres[y * columns + x] = value * unit_m;
    }
    [before, row] = [row, before];
  }
  if (at !== bytes.length) throw refused('it goes on after its end');
  return metres;
}

/** Metres above the ellipsoid at a place, degrees; beyond the grid as at its border. */
export function undulationAt({ first, step, columns, rows, metres }: Undulations, lat: number, lon: number): number {
  const cell = (at: number, count: number) => {
    const inside = Math.min(Math.max(at, 0), count - 1), index = Math.min(Math.floor(inside), count - 2);
    return [index, inside - index] as const;
  };
  const [x, east] = cell((lon - first[0]) / step[0], columns), [y, north] = cell((lat - first[1]) / step[1], rows), at = y * columns + x;
  return (1 - north) * ((1 - east) * metres[at]! + east * metres[at + 1]!) + north * ((1 - east) * metres[at + columns]! + east * metres[at + columns + 1]!);
}
