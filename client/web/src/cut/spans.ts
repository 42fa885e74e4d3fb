// What of a straight way a cut leaves. Pure.
import { isInside, type At } from './ring';

// From one share of the way to another one. It may begin at the cut's wall, where what is kept begins behind what is cut away.
export interface Span {
  from: number;
  to: number;
  is_at_wall: boolean;
}

export interface Kept {
  ring: readonly At[];
  is_hole: boolean; // what is inside is taken away, and not what is outside
}

export const isKept = ({ ring, is_hole }: Kept, at: At): boolean => isInside(ring, at) !== is_hole;

const kSteps = 60, kClose = 1e-13; // towards a crossing

// `latticeAt` has the place on the lattice of a share of the way, which is straight there, but for what it bends within so many `pieces`. Spans
// come one after another.
export function spansAlong(kept: Kept, latticeAt: (share: number) => At, pieces: number): Span[] {
  const ends = [0, ...crossingsOf(kept.ring, latticeAt, pieces), 1], spans: Span[] = [];
  ends.slice(1).forEach((to, i) => {
    const from = ends[i]!, last = spans.at(-1);
    if (to <= from || !isKept(kept, latticeAt((from + to) / 2))) return;
    if (last?.to === from) last.to = to;
    else spans.push({ from, to, is_at_wall: from > 0 });
  });
  return spans;
}

// Shares of the way where it crosses an edge of the ring, from less to more.
function crossingsOf(ring: readonly At[], latticeAt: (share: number) => At, pieces: number): number[] {
  const places = Array.from({ length: pieces + 1 }, (_, i) => latticeAt(i / pieces)), found: number[] = [];
  ring.forEach((a, i) => {
    const b = ring[(i + 1) % ring.length]!, side = ([x, y]: At) => (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    const sides = places.map(side);
    for (let k = 0; k < pieces; ++k) {
      if (sides[k]! >= 0 === sides[k + 1]! >= 0) continue;
      const share = rootOf((t) => side(latticeAt(t)), [k / pieces, sides[k]!], [(k + 1) / pieces, sides[k + 1]!]);
      if (isBetween(a, b, latticeAt(share))) found.push(share);
    }
  });
  return found.sort((a, b) => a - b);
}

// Where a function of nearly straight values is 0, between two places on whose sides it differs: by false position, as Illinois has it.
function rootOf(of: (t: number) => number, [low, at_low]: At, [high, at_high]: At): number {
  let [t, before, side] = [low, high, 0];
  for (let i = 0; i < kSteps && Math.abs(t - before) > kClose; ++i) {
    [before, t] = [t, (low * at_high - high * at_low) / (at_high - at_low)];
    const value = of(t);
    if (value >= 0 === at_high >= 0) {
      [high, at_high] = [t, value];
      if (side === 1) at_low /= 2;
      side = 1;
    } else {
      [low, at_low] = [t, value];
      if (side === -1) at_high /= 2;
      side = -1;
    }
  }
  return t;
}

// Of a place on the line through both, with some room at the corners: a crossing too many divides a span that is put together again.
function isBetween(a: At, b: At, at: At): boolean {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]], along = ((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / (dx * dx + dy * dy);
  return along >= -1e-6 && along <= 1 + 1e-6;
}
