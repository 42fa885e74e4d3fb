// What a cut leaves of a scene: what is inside of a ring on its lattice, or outside of it. Pure.
export type At = readonly [number, number]; // on the lattice

export const kMostCorners = 16; // of a ring: u_cut of draw/shaders/cut.glsl

// What of the data, and a step around it, lies left of the line from `a` through `b`, which are apart. Empty if the line has all of it right.
export function halfOf(samples: At, a: At, b: At): At[] {
  const [right, top] = samples, whole: At[] = [[-1, -1], [right, -1], [right, top], [-1, top]];
  const side = ([x, y]: At) => (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
  return whole.flatMap((corner, i) => {
    const next = whole[(i + 1) % whole.length]!, [here, there] = [side(corner), side(next)];
    const kept: At[] = here >= 0 ? [corner] : [];
    if (here >= 0 === there >= 0) return kept;
    const t = here / (here - there);
    return [...kept, [corner[0] + t * (next[0] - corner[0]), corner[1] + t * (next[1] - corner[1])] as const];
  });
}

export function isInside(ring: readonly At[], [x, y]: At): boolean {
  let is_inside = false;
  ring.forEach(([ax, ay], i) => {
    const [bx, by] = ring[(i + ring.length - 1) % ring.length]!;
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) is_inside = !is_inside;
  });
  return is_inside;
}

// Places along a ring, about a step of the lattice apart, or so far that there are no more than `most` in all; by edges, each with both its ends.
export function alongEdges(ring: readonly At[], most: number): At[][] {
  const edges = ring.map((from, i) => [from, ring[(i + 1) % ring.length]!] as const);
  const length = edges.reduce((sum, [a, b]) => sum + Math.hypot(b[0] - a[0], b[1] - a[1]), 0), step = Math.max(1, length / Math.max(most - 2 * ring.length, 1));
  return edges.map(([a, b]) => {
    const count = Math.max(1, Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / step));
    return Array.from({ length: count + 1 }, (_, i) => [a[0] + ((b[0] - a[0]) * i) / count, a[1] + ((b[1] - a[1]) * i) / count] as const);
  });
}
