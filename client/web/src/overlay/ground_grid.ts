// Lines and areas laid out for a shader that draws them into the ground itself (draw/shaders/overlay.glsl): a pyramid of grids over the
// lattice, each cell with all that comes near it. A pixel looks into the level whose cells are at least twice as wide as half a line is
// there; that level's geometry is simplified to a sixteenth of a cell, so a line is off by an eighth of its half width at most, and a cell
// has few parts however far away one is. The finest level has the geometry as it is.
import type { FeatureStyle } from './feature';

export type Point = readonly [x: number, y: number]; // on the lattice

export interface GroundShape {
  kind: 'line' | 'area';
  parts: Point[][];
  style: FeatureStyle;
  feature: number; // by which it is known to whom asks what is at a place
}

// What a cell has, in the order of drawing: of each shape a beginning, then what of it is near.
export const kBegin = 0, kCovers = 1, kSegment = 2; // the upper two bits of an item; the lower 30 name a shape or a segment
export const kIndexBits = 30;

export interface GroundGrid {
  origin: Point; // of the finest level's first cell; segments count from it
  cell: number; // sample intervals, of the finest level
  levels: { columns: number; rows: number; begin: number }[]; // `begin` of its cells among all
  cells: Uint32Array<ArrayBuffer>; // first item and count, of each cell, level by level
  items: Uint32Array<ArrayBuffer>;
  segments: Float32Array<ArrayBuffer>; // both ends
  styles: Float32Array<ArrayBuffer>; // of each shape: stroke with opacity; fill with opacity; width, is an area, -, -
  features: Int32Array<ArrayBuffer>; // of each shape
}

const kFinest = [512, 1024] as const; // cells along the longer side, at least and at most
const kSimpler = 16; // of a cell's side
const kMaxItems = 1 << 22;
const kReach = 0.5; // of a cell: how far outside of it what it has may be

// At least one shape; about 40 bytes a vertex, at most some tens of megabytes. Takes about a second for a million vertices.
export function buildGroundGrid(shapes: readonly GroundShape[]): GroundGrid {
  const { low, size } = boxOf(shapes);
  const vertices = shapes.reduce((sum, { parts }) => sum + parts.reduce((count, part) => count + part.length, 0), 0);
  const cell = Math.max(size[0], size[1], 1e-3) / Math.min(Math.max(Math.ceil(2 * Math.sqrt(vertices)), kFinest[0]), kFinest[1]);
  const columns = Math.max(1, Math.ceil(size[0] / cell)), rows = Math.max(1, Math.ceil(size[1] / cell));
  const builder = new Builder(low, shapes);
  for (let level = 0; ; ++level) {
    const [across, up] = [columns, rows].map((count) => Math.ceil(count / 2 ** level)) as [number, number];
    builder.addLevel(across, up, cell * 2 ** level, level > 0);
    if (across === 1 && up === 1) break;
  }
  return builder.grid(low, cell);
}

function boxOf(shapes: readonly GroundShape[]): { low: Point; size: Point } {
  let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { parts } of shapes)
    for (const part of parts) for (const [x, y] of part) [x0, y0, x1, y1] = [Math.min(x0, x), Math.min(y0, y), Math.max(x1, x), Math.max(y1, y)];
  return { low: [x0, y0], size: [x1 - x0, y1 - y0] };
}

class Builder {
  private readonly levels: GroundGrid['levels'] = [];
  private readonly cells = new Column();
  private readonly items = new Column();
  private readonly segments: number[] = [];

  constructor(private readonly low: Point, private readonly shapes: readonly GroundShape[]) {}

  addLevel(columns: number, rows: number, cell: number, is_simpler: boolean): void {
    const level = new Level(columns, rows, cell);
    for (const [index, shape] of this.shapes.entries()) {
      level.begin(index);
      const rings = shape.parts.map((part) => part.map(([x, y]): Point => [x - this.low[0], y - this.low[1]]));
      const parts = is_simpler ? rings.map((part) => simplified(part, cell / kSimpler)) : rings;
      if (shape.kind === 'area') level.cover(parts);
      for (const part of parts) {
        for (let i = 1; i < part.length; ++i) {
          level.cross(part[i - 1]!, part[i]!, this.segments.length / 4);
          this.segments.push(...part[i - 1]!, ...part[i]!);
        }
      }
    }
    this.levels.push({ columns, rows, begin: this.cells.length / 2 });
    if (this.items.length + level.length > kMaxItems) throw new Error('It has too many lines and areas over one another to be drawn.');
    level.sortInto(this.cells, this.items);
  }

  grid(origin: Point, cell: number): GroundGrid {
    const styles = this.shapes.flatMap(({ kind, style: s }) => [...s.stroke, s.stroke_opacity, ...s.fill, s.fill_opacity, s.stroke_px, kind === 'area' ? 1 : 0, 0, 0]);
    return {
      origin, cell, levels: this.levels, cells: this.cells.whole(), items: this.items.whole(), segments: Float32Array.from(this.segments),
      styles: Float32Array.from(styles), features: Int32Array.from(this.shapes, (shape) => shape.feature),
    };
  }
}

// Items of one level as they come, by cell.
class Level {
  private readonly of_cell = new Column();
  private readonly item = new Column();
  private readonly last: Int32Array; // the shape that each cell has begun last
  private shape = 0;

  constructor(private readonly columns: number, private readonly rows: number, private readonly cell: number) {
    this.last = new Int32Array(columns * rows).fill(-1);
  }
  get length(): number {
    return this.item.length;
  }
  begin(shape: number): void {
    this.shape = shape;
  }

  // The cells whose middle lies inside of rings: an odd number of times.
  cover(rings: readonly (readonly Point[])[]): void {
    const crossings: number[][] = Array.from({ length: this.rows }, () => []);
    for (const ring of rings)
      for (let i = 0; i < ring.length; ++i) {
        const [a, b] = [ring[i]!, ring[(i + 1) % ring.length]!];
        const [lower, upper] = a[1] < b[1] ? [a, b] : [b, a];
        const first = Math.max(0, Math.ceil(lower[1] / this.cell - 0.5));
        for (let row = first; row < this.rows && (row + 0.5) * this.cell < upper[1]; ++row) {
          if ((row + 0.5) * this.cell < lower[1]) continue;
          crossings[row]!.push(lower[0] + ((upper[0] - lower[0]) * ((row + 0.5) * this.cell - lower[1])) / (upper[1] - lower[1]));
        }
      }
    crossings.forEach((xs, row) => {
      xs.sort((a, b) => a - b);
      for (let i = 0; i + 1 < xs.length; i += 2) {
        const first = Math.max(0, Math.ceil(xs[i]! / this.cell - 0.5)), end = Math.min(this.columns, Math.ceil(xs[i + 1]! / this.cell - 0.5));
        for (let column = first; column < end; ++column) this.add(row * this.columns + column, kCovers, this.shape);
      }
    });
  }

  // The cells that come within their reach of a segment, and perhaps some more.
  cross(a: Point, b: Point, segment: number): void {
    const reach = kReach * this.cell;
    const [lower, upper] = a[1] < b[1] ? [a, b] : [b, a];
    const [first, last] = [this.indexOf(lower[1] - reach, this.rows), this.indexOf(upper[1] + reach, this.rows)];
    const slope = upper[1] > lower[1] ? (upper[0] - lower[0]) / (upper[1] - lower[1]) : 0;
    const xAt = (y: number) => lower[0] + slope * (Math.min(Math.max(y, lower[1]), upper[1]) - lower[1]);
    for (let row = first; row <= last; ++row) {
      const ends = slope === 0 ? [a[0], b[0]] : [xAt(row * this.cell - reach), xAt((row + 1) * this.cell + reach)];
      const end = this.indexOf(Math.max(...ends) + reach, this.columns);
      for (let column = this.indexOf(Math.min(...ends) - reach, this.columns); column <= end; ++column)
        this.add(row * this.columns + column, kSegment, segment);
    }
  }

  // By cell, and within a cell as they came.
  sortInto(cells: Column, items: Column): void {
    const count = new Uint32Array(this.columns * this.rows);
    for (let i = 0; i < this.length; ++i) ++count[this.of_cell.at(i)]!;
    const next = new Uint32Array(count.length);
    let begin = items.length;
    count.forEach((n, cell) => {
      next[cell] = begin;
      cells.push(begin, n);
      begin += n;
    });
    items.grow(begin);
    for (let i = 0; i < this.length; ++i) items.set(next[this.of_cell.at(i)]!++, this.item.at(i));
  }

  private indexOf(at: number, count: number): number {
    return Math.min(Math.max(Math.floor(at / this.cell), 0), count - 1);
  }
  private add(cell: number, kind: number, index: number): void {
    if (this.last[cell] !== this.shape) {
      this.last[cell] = this.shape;
      this.push(cell, kBegin, this.shape);
    }
    this.push(cell, kind, index);
  }
  private push(cell: number, kind: number, index: number): void {
    if (this.length >= kMaxItems) throw new Error('It has too many lines and areas over one another to be drawn.');
    this.of_cell.push(cell);
    this.item.push(kind * 2 ** kIndexBits + index);
  }
}

// Numbers of 32 bits, as many as come.
class Column {
  private numbers = new Uint32Array(1024);
  length = 0;

  push(...more: number[]): void {
    this.reserve(this.length + more.length);
    for (const number of more) this.numbers[this.length++] = number;
  }
  grow(length: number): void {
    this.reserve(length);
    this.length = length;
  }
  at(i: number): number {
    return this.numbers[i]!;
  }
  set(i: number, number: number): void {
    this.numbers[i] = number;
  }
  whole(): Uint32Array<ArrayBuffer> {
    return this.numbers.slice(0, this.length);
  }
  private reserve(length: number): void {
    if (length <= this.numbers.length) return;
    const larger = new Uint32Array(Math.max(length, 2 * this.numbers.length));
    larger.set(this.numbers);
    this.numbers = larger;
  }
}

// Douglas and Peucker's: what is left out lies within the tolerance of what is kept. Ends stay.
export function simplified(line: readonly Point[], tolerance: number): Point[] {
  if (line.length < 3) return [...line];
  const keeps = new Uint8Array(line.length);
  keeps[0] = keeps[line.length - 1] = 1;
  for (const open: [number, number][] = [[0, line.length - 1]]; open.length > 0;) {
    const [first, last] = open.pop()!;
    let [farthest, at] = [tolerance, -1];
    for (let i = first + 1; i < last; ++i) {
      const distance = distanceTo(line[i]!, line[first]!, line[last]!);
      if (distance > farthest) [farthest, at] = [distance, i];
    }
    if (at < 0) continue;
    keeps[at] = 1;
    open.push([first, at], [at, last]);
  }
  return line.filter((_, i) => keeps[i] === 1);
}

// From a point to a segment.
export function distanceTo([x, y]: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay], length2 = dx * dx + dy * dy;
  const t = length2 > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / length2, 0), 1) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}
