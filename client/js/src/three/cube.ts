// A globe's faces (proto/space/cube_map.h), as far as what is drawn needs them: which place of each face is nearest to a point.
export const kFaces = 6;
// Of each face's east, north and middle: the axis of the body, 1 to 3, with its sign.
const kAxes = [[2, 3, 1], [-1, 3, 2], [-1, -2, 3], [-3, -2, -1], [-3, 1, -2], [2, 1, -3]] as const;
const kFirst = Math.PI / 4, kThird = 0.1615, kFifth = 1 - kFirst - kThird;

export function cubeTangent(s: number): number {
  return s * (kFirst + s * s * (kThird + s * s * kFifth));
}
function cubeCoordinate(tangent: number): number {
  const u = Math.min(Math.max(tangent, -1), 1);
  let s = u;
  for (let i = 0; i < 6; ++i) s -= (cubeTangent(s) - u) / (kFirst + s * s * (3 * kThird + s * s * 5 * kFifth));
  return Math.min(Math.max(s, -1), 1);
}

// By a position on the lattice of faces with so many steps a side: for each face the whole position on its square that is nearest, each
// coordinate by itself; the middle of faces beyond the body's middle.
export function nearestOnFaces(lattice: readonly [number, number], steps: number): [number, number][] {
  const own = Math.min(Math.max(Math.floor(lattice[0] / steps), 0), kFaces - 1);
  const tangent = (v: number) => cubeTangent((2 * v) / steps - 1);
  const along = [tangent(lattice[0] - own * steps), tangent(lattice[1]), 1], direction = [0, 0, 0];
  kAxes[own]!.forEach((axis, i) => (direction[Math.abs(axis) - 1] = Math.sign(axis) * along[i]!));
  return kAxes.map((axes) => {
    const [east, north, out] = axes.map((axis) => Math.sign(axis) * direction[Math.abs(axis) - 1]!) as [number, number, number];
    const step = (v: number) => Math.round(0.5 * steps * (1 + (out > 1e-9 ? cubeCoordinate(v / out) : 0)));
    return [step(east), step(north)];
  });
}
