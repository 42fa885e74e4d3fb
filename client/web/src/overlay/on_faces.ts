// Lines and areas over a globe. Its lattice has the cube's faces side by side, and bends what is straight in longitude and latitude: so lines
// are brought there in pieces, none of which leaves its face, and areas as what each face has of them. Pure.
import type { Places } from './feature';
import { isAbout } from './find_feature';
import type { Point } from './ground_grid';

export interface Faces {
  at: (lon: number, lat: number) => Point; // on the lattice
  side: number; // of a face, sample intervals
}

export const kBend = 2 ** -20; // by which a piece may be off, of a face's side: ten metres on the earth
const kStraight_deg = 0.02; // what is shorter bends less
const kLong_deg = 5; // what is longer may bend both ways
const kHalvings = 40; // of a step, until it ends at the side of a face
export const kOften = 128; // places between yields

// Of a line its pieces. A generator, for slices (slices.ts).
export function* piecesOf(faces: Faces, places: Places): Generator<void, Point[][]> {
  const tracer = new Tracer(faces);
  for (let i = 0; i < places.length; i += 2) {
    tracer.go([places[i]!, places[i + 1]!]);
    if (i % (2 * kOften) === 0) yield;
  }
  return tracer.pieces;
}

// Of an area's rings their pieces as lines, and rings on the faces, in the same faces an odd number of which are about what it has.
export function* areaOf(faces: Faces, rings: readonly Places[]): Generator<void, { outline: Point[][]; rings: Point[][] }> {
  const outline: Point[][] = [], closed: Point[][] = [];
  for (const ring of rings) {
    const is_closed = ring[0] === ring[ring.length - 2] && ring[1] === ring[ring.length - 1];
    const pieces = yield* piecesOf(faces, is_closed ? ring : Float64Array.of(...ring, ring[0]!, ring[1]!)), [first, last] = [pieces[0]!, pieces[pieces.length - 1]!];
    outline.push(...pieces);
    if (pieces.length === 1) closed.push(first);
    else if (faceOf(faces, first[0]!) === faceOf(faces, last[0]!)) closed.push(...[[...last, ...first.slice(1)], ...pieces.slice(1, -1)].map((piece) => closedBySides(faces, piece)));
    else closed.push(...pieces.map((piece) => closedBySides(faces, piece)));
  }
  for (const [lon, lat] of kOnFaces) {
    const at = faces.at(lon, lat), face = faceOf(faces, at), own = closed.filter((ring) => faceOf(faces, ring[0]!) === face).map((ring) => Float64Array.from(ring.flat()));
    if (isAbout(own, at) !== isOnArea(rings, lon, lat)) closed.push(cornersOf(faces, face)); // it was closed the other way around
  }
  return { outline, rings: closed };
}

// A place on each face, about its middle.
const kOnFaces = [[3.17, 4.71], [93.17, 4.71], [-176.83, 4.71], [-86.83, 4.71], [13.1, 83.3], [13.1, -83.3]] as const;

// By longitude and latitude, as areas are meant. Some go on beyond 180 degrees.
function isOnArea(rings: readonly Places[], lon: number, lat: number): boolean {
  return [-720, -360, 0, 360, 720].filter((turn) => isAbout(rings, [lon + turn, lat])).length % 2 === 1;
}

function faceOf({ side }: Faces, [x]: Point): number {
  return Math.min(Math.floor(x / side), 5);
}
function cornersOf({ side }: Faces, face: number): Point[] {
  return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([x, y]) => [(face + x!) * side, y! * side]);
}

// A piece from side to side of its face, and back along the sides, against the clock.
function closedBySides(faces: Faces, piece: Point[]): Point[] {
  const { side } = faces, face = faceOf(faces, piece[0]!), corners = cornersOf(faces, face);
  const around = ([x, y]: Point) => {
    const [u, v] = [x / side - face, y / side], beside = [v, 1 - u, 1 - v, u];
    const nearest = beside.indexOf(Math.min(...beside));
    return nearest + [u, v, 1 - u, 1 - v][nearest]!;
  };
  const from = around(piece[piece.length - 1]!), to = around(piece[0]!), ring = [...piece];
  for (let corner = Math.floor(from) + 1; corner <= (to < from ? to + 4 : to); ++corner) ring.push(corners[corner % 4]!);
  return [...ring, piece[0]!];
}

// Follows places in longitude and latitude, along straight ways.
class Tracer {
  readonly pieces: Point[][] = [];
  private from: { place: Point; at: Point } | null = null;

  constructor(private readonly faces: Faces) {}

  go(place: Point): void {
    const at = this.faces.at(...place), to = { place, at };
    if (this.from) this.step(this.from, to, 0);
    else this.pieces.push([at]);
    this.from = to;
  }

  private step(from: { place: Point; at: Point }, to: { place: Point; at: Point }, halvings: number): void {
    const is_one_face = faceOf(this.faces, from.at) === faceOf(this.faces, to.at), middle = mean(from.place, to.place);
    const length_deg = Math.hypot((to.place[0] - from.place[0]) * Math.cos((middle[1] * Math.PI) / 180), to.place[1] - from.place[1]);
    if (is_one_face && length_deg < kStraight_deg) return void this.pieces[this.pieces.length - 1]!.push(to.at);
    if (halvings === kHalvings) return void (is_one_face ? this.pieces[this.pieces.length - 1]!.push(to.at) : this.pieces.push([to.at]));
    const between = { place: middle, at: this.faces.at(...middle) }, straight = mean(from.at, to.at);
    const bend = Math.hypot(between.at[0] - straight[0], between.at[1] - straight[1]);
    if (is_one_face && length_deg < kLong_deg && bend <= kBend * this.faces.side) return void this.pieces[this.pieces.length - 1]!.push(to.at);
    this.step(from, between, halvings + 1);
    this.step(between, to, halvings + 1);
  }
}

function mean([ax, ay]: Point, [bx, by]: Point): Point {
  return [(ax + bx) / 2, (ay + by) / 2];
}
