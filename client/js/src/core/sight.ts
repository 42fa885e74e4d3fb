// What is seen from here: questions that the server answers exactly, on the ground and the objects at full resolution. Positions are
// lattice position and height in metres; docs/PROTOCOL.md, section 19.
import type { Core } from './core.js';

export type Point = readonly [x: number, y: number, height_m: number];
export type Vector = [number, number, number];

export const kUsualRefraction = 1 / 7; // of air: the share of the earth's curvature by which light bends

export interface SightQuestion {
  pairs: readonly (readonly [from: Point, to: Point])[]; // at most 4096
  above?: 'ground' | 'zero surface'; // what heights are above; the ground without it
  refraction?: number;
  scene_ms?: number; // of a scene that changes in time; without it the last date's
}
export interface ViewshedQuestion {
  observer: readonly [x: number, y: number];
  observer_m: number; // of the eye, above the ground
  target_m?: number; // of what is looked at, above the ground
  radius_m: number;
  cell_m: number;
  refraction?: number;
  scene_ms?: number;
}

export interface Sight {
  from: Vector; // scene frame
  to: Vector;
  hit: Vector | null; // the first point that hides; null: none does
  object: number | null; // that hides; null: the ground, or none
  is_known: boolean; // false if an end lies beyond the data: it has no ground
}
/**
 * Which cells about a point are seen from it. The middle of cell (i, j) is at `first` + (i, j) `step` on the lattice of the data's samples
 * (`Place.lattice`); cells go eastward, row by row from the south.
 */
export interface Viewshed {
  readonly first: [number, number];
  readonly step: [number, number];
  readonly columns: number;
  readonly rows: number;
  /** 0 hidden, 1 seen, 2 beyond the radius or the data, or not known yet. */
  readonly cells: Uint8Array<ArrayBuffer>;
  /** So many cells are known, from the first on. */
  known: number;
}

const kLatest_ms = 2 ** 60 / 1000;

// What is told to the worker, and by it (messages.ts).
export type SightMessage =
  | { kind: 'ask sight'; ask: number; question: SightQuestion }
  | { kind: 'ask viewshed'; ask: number; question: ViewshedQuestion }
  | { kind: 'cancel sight'; ask: number }
  | { kind: 'forget sight'; ask: number }; // it has been answered
export type SightAnswer =
  | { kind: 'sight asked'; ask: number; id: number } // the reply will have this number
  | { kind: 'sight'; message: Uint8Array }
  | { kind: 'sight lost' }; // the connection was lost, and what was asked with it

// The worker's part: asks through a viewer, and says which reply will be which.
export class SightAsker {
  private readonly ids = new Map<number, number>(); // by ask, of what is not answered yet

  constructor(private readonly core: Core, private readonly handle: () => number, private readonly post: (answer: SightAnswer) => void) {}

  handleMessage(message: SightMessage): void {
    const { exports } = this.core;
    if (message.kind === 'cancel sight' || message.kind === 'forget sight') {
      const id = this.ids.get(message.ask);
      this.ids.delete(message.ask);
      if (id !== undefined && message.kind === 'cancel sight') exports.foreland_cancel_request(this.handle(), id);
      return;
    }
    const { question } = message;
    const [refraction, scene_ms] = [question.refraction ?? kUsualRefraction, question.scene_ms ?? kLatest_ms];
    let id: number;
    if (message.kind === 'ask sight') {
      const numbers = message.question.pairs.flatMap(([from, to]) => [...from, ...to]);
      this.core.put(new Uint8Array(Float64Array.from(numbers).buffer));
      id = exports.foreland_request_sight(this.handle(), message.question.above === 'zero surface' ? 1 : 0, refraction, scene_ms);
    } else {
      const q = message.question;
      id = exports.foreland_request_viewshed(this.handle(), q.observer[0], q.observer[1], q.observer_m, q.target_m ?? 0, q.radius_m, q.cell_m,
        refraction, scene_ms);
    }
    this.ids.set(message.ask, id);
    this.post({ kind: 'sight asked', ask: message.ask, id });
  }

  // A message of the server was received: hands on what the drawing thread waits for.
  received(message: Uint8Array): void {
    if (this.core.exports.foreland_take_sight(this.handle()) > 0) this.post({ kind: 'sight', message });
  }
  // A session begins: nothing that was asked before is answered.
  begin(): void {
    if (this.ids.size > 0) this.post({ kind: 'sight lost' });
    this.ids.clear();
  }
}

interface Waiting {
  id: number; // of the reply; 0: not known yet
  take(numbers: Float64Array, error: string): boolean; // whether it is whole
  fail(reason: Error): void;
}

// The page's part, on a session.
export class Sights {
  private readonly waiting = new Map<number, Waiting>(); // by ask
  private next = 1;
  private endViewshed: (reason: unknown) => void = () => {}; // of the one that waits

  constructor(private readonly core: Core, private readonly tell: (message: SightMessage) => void) {}

  // Whether the second point of each pair is seen from the first.
  visible(question: SightQuestion): Promise<Sight[]> {
    return new Promise((resolve, reject) => {
      this.ask({ kind: 'ask sight', ask: this.next, question }, reject, (numbers) => {
        resolve(Array.from({ length: (numbers.length - 1) / 10 }, (_, i) => sightOf(numbers.subarray(1 + 10 * i, 11 + 10 * i))));
        return true;
      });
    });
  }

  // What is seen from a point; `onCells` is called as cells become known. Another one takes its place. Ends by `signal`.
  viewshed(question: ViewshedQuestion, onCells: (viewshed: Viewshed) => void = () => {}, signal?: AbortSignal): Promise<Viewshed> {
    this.endViewshed(new Error('Another viewshed was asked for instead.'));
    return new Promise((resolve, reject) => {
      let viewshed: Viewshed | null = null;
      const ask = this.ask({ kind: 'ask viewshed', ask: this.next, question }, reject, (numbers) => {
        viewshed ??= viewshedOf(numbers);
        const begin = numbers[7]!;
        viewshed.cells.set(numbers.subarray(8), begin);
        viewshed.known = begin + numbers.length - 8;
        onCells(viewshed);
        if (viewshed.known < viewshed.cells.length) return false;
        resolve(viewshed);
        return true;
      });
      this.endViewshed = (reason) => {
        if (!this.waiting.delete(ask)) return;
        this.tell({ kind: 'cancel sight', ask });
        reject(reason);
      };
      const end = this.endViewshed;
      signal?.addEventListener('abort', () => end(signal.reason), { once: true });
    });
  }

  receive(answer: SightAnswer): void {
    if (answer.kind === 'sight lost') return this.end(new Error('The connection was lost before the server could answer.'));
    if (answer.kind === 'sight asked') {
      const asked = this.waiting.get(answer.ask);
      if (asked) asked.id = answer.id;
      return;
    }
    this.core.put(answer.message);
    const record = this.core.exports.foreland_read_sight();
    if (record === 0) return;
    const [address, size] = [this.core.view().getUint32(record, true), this.core.view().getUint32(record + 4, true)];
    const numbers = new Float64Array(this.core.copy(address, size).buffer);
    this.give(numbers, this.core.textAt(this.core.exports.foreland_sight_error()));
  }

  private ask(message: SightMessage & { question: unknown }, fail: (reason: Error) => void, take: (numbers: Float64Array) => boolean): number {
    const ask = this.next++;
    const takeOrFail = (numbers: Float64Array, error: string) => {
      if (error === '') return take(numbers);
      fail(new Error(error));
      return true;
    };
    this.waiting.set(ask, { id: 0, take: takeOrFail, fail });
    this.tell(message);
    return ask;
  }

  private give(numbers: Float64Array, error: string): void {
    for (const [ask, waits] of this.waiting) {
      if (waits.id !== numbers[0] || !waits.take(numbers, error)) continue;
      this.waiting.delete(ask);
      this.tell({ kind: 'forget sight', ask });
    }
  }

  // Nothing that was asked is answered any more.
  end(reason: Error): void {
    const all = [...this.waiting.values()];
    this.waiting.clear();
    for (const waits of all) waits.fail(reason);
  }
}

function vectorAt(numbers: Float64Array, at: number): Vector {
  return [numbers[at]!, numbers[at + 1]!, numbers[at + 2]!];
}

function sightOf(numbers: Float64Array): Sight {
  const [kNothing, kUnknown] = [-2, -3];
  const what = numbers[9]!;
  return {
    from: vectorAt(numbers, 0),
    to: vectorAt(numbers, 3),
    hit: what === kNothing || what === kUnknown ? null : vectorAt(numbers, 6),
    object: what >= 0 ? what : null,
    is_known: what !== kUnknown,
  };
}

function viewshedOf(numbers: Float64Array): Viewshed {
  const [, x, y, step_x, step_y, columns, rows] = numbers as unknown as number[];
  const cells = new Uint8Array(columns! * rows!).fill(2);
  return { first: [x!, y!], step: [step_x!, step_y!], columns: columns!, rows: rows!, cells, known: 0 };
}
