// Heights drawn taller, or flatter, than they are. What is drawn is the scene under a map that multiplies heights and leaves the rest, as seen
// by a camera whose eye is where the true one is. The server knows nothing of that: it is asked for a view of the true scene that contains
// all that the drawn one shows, with a tolerance so much smaller that no error is larger than wanted where it is drawn. So the bound holds,
// and what ridges hide stays hidden: the map takes straight lines to straight lines. Pure.
import type { Pose } from '@foreland/client';

export const kExaggerations = { least: 0.5, most: 5 };

type Triple = [number, number, number];

// What the server is told of a camera that draws heights `factor` times as tall: it looks at the middle, from below to above, of what is drawn.
export function askedPose(pose: Pose, factor: number, fov_rad: number): Pose {
  if (factor === 1) return pose;
  const [top, bottom] = [1, -1].map((side) => unit(tall(turned(pose, [0, side * Math.tan(fov_rad / 2), -1]), 1 / factor))) as [Triple, Triple];
  const ahead = unit(top.map((v, i) => v + bottom[i]!) as Triple), rise = top.map((v, i) => v - bottom[i]!) as Triple, along = dot(rise, ahead);
  const up = unit(rise.map((v, i) => v - along * ahead[i]!) as Triple);
  return { eye: pose.eye, orientation: quaternionOf(cross(ahead, up), up, ahead.map((v) => -v) as Triple) };
}

// The camera without roll of which the server is told `asked`.
export function shownPose(asked: Pose, factor: number, fov_rad: number): Pose {
  if (factor === 1) return asked;
  const raised = (angle: number): Pose => ({ eye: asked.eye, orientation: product(asked.orientation, [Math.sin(angle / 2), 0, 0, Math.cos(angle / 2)]) });
  const up = turned(asked, [0, 1, 0]), back = turned(asked, [0, 0, 1]);
  let [low, high] = [-Math.PI / 2, Math.PI / 2];
  for (let i = 0; i < kHalvings; ++i) {
    const middle = (low + high) / 2, ahead = turned(askedPose(raised(middle), factor, fov_rad), [0, 0, -1]);
    if (Math.atan2(dot(ahead, up), -dot(ahead, back)) < 0) low = middle;
    else high = middle;
  }
  return raised((low + high) / 2);
}

export interface AskedLens {
  tan_x: number; // of half the angles that it sees
  tan_y: number;
  finer: number; // how much smaller the tolerance has to be
}

const kHalvings = 40;
const kPitches = 181, kSteps = 9; // that are looked at
const kSpare = 1.02; // for what is between them
const kMost = 8; // of tangents: a lens of nearly half a turn

// Of a lens, at a factor: for all directions that a camera without roll can have.
export function askedLens(fov_rad: number, aspect: number, factor: number): AskedLens {
  const tall_0 = Math.tan(fov_rad / 2), wide_0 = tall_0 * aspect;
  if (factor === 1) return { tan_x: wide_0, tan_y: tall_0, finer: 1 };
  let [tan_x, tan_y, finer] = [wide_0, tall_0, 1];
  for (let i = 0; i < kPitches; ++i) {
    const pitch = Math.PI * (i / (kPitches - 1) - 0.5), shown: Pose = { eye: [0, 0, 0], orientation: [Math.sin(Math.PI / 4 + pitch / 2), 0, 0, Math.cos(Math.PI / 4 + pitch / 2)] };
    const asked = askedPose(shown, factor, fov_rad);
    for (let v = -1; v <= 1; v += 2 / (kSteps - 1))
      for (let u = -1; u <= 1; u += 2 / (kSteps - 1)) {
        const direction = turned(shown, [u * wide_0, v * tall_0, -1]), true_one = tall(direction, 1 / factor);
        const [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, -1]].map((axis) => dot(true_one, turned(asked, axis as Triple))) as Triple;
        if (z <= 0) {
          tan_x = tan_y = kMost;
          continue;
        }
        [tan_x, tan_y] = [Math.max(tan_x, Math.abs(x / z)), Math.max(tan_y, Math.abs(y / z))];
        finer = Math.max(finer, growth(shown, asked, [x / z, y / z], factor));
      }
  }
  return { tan_x: Math.min(kSpare * tan_x, kMost), tan_y: Math.min(kSpare * tan_y, kMost), finer: kSpare * finer };
}

// How much longer a small step about a place of the asked picture is in the shown one, at most.
export function growth(shown: Pose, asked: Pose, [x, y]: readonly [number, number], factor: number): number {
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, -1]].map((axis) => turned(shown, axis as Triple));
  const at = (ax: number, ay: number) => axes.map((axis) => dot(tall(turned(asked, [ax, ay, -1]), factor), axis)) as Triple;
  const [X, Y, Z] = at(x, y), column = (ax: number, ay: number) => {
    const [dX, dY, dZ] = at(x + ax, y + ay).map((v, i) => v - [X, Y, Z][i]!) as Triple; // exact: the map is linear
    return [(dX * Z - X * dZ) / Z ** 2, (dY * Z - Y * dZ) / Z ** 2] as const;
  };
  const [[a, c], [b, d]] = [column(1, 0), column(0, 1)], sum = a * a + b * b + c * c + d * d, area = a * d - b * c;
  return Math.sqrt((sum + Math.sqrt(Math.max(sum * sum - 4 * area * area, 0))) / 2); // the larger singular value
}

const tall = ([x, y, z]: Readonly<Triple>, factor: number): Triple => [x, y, factor * z];
const dot = (a: readonly number[], b: readonly number[]): number => a.reduce((sum, v, i) => sum + v * b[i]!, 0);
const cross = ([a, b, c]: Readonly<Triple>, [d, e, f]: Readonly<Triple>): Triple => [b * f - c * e, c * d - a * f, a * e - b * d];
const unit = (v: Readonly<Triple>): Triple => v.map((x) => x / Math.hypot(...v)) as Triple;

function turned({ orientation: [x, y, z, w] }: Pose, v: Readonly<Triple>): Triple {
  const axis: Triple = [x, y, z], t = cross(axis, v).map((c) => 2 * c) as Triple, across = cross(axis, t);
  return v.map((c, i) => c + w * t[i]! + across[i]!) as Triple;
}

function product([ax, ay, az, aw]: Pose['orientation'], [bx, by, bz, bw]: Pose['orientation']): [number, number, number, number] {
  return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
}

// Of a rotation by its columns.
function quaternionOf([a, d, g]: Readonly<Triple>, [b, e, h]: Readonly<Triple>, [c, f, i]: Readonly<Triple>): [number, number, number, number] {
  const four = [1 + a - e - i, 1 - a + e - i, 1 - a - e + i, 1 + a + e + i]; // times the squares of x, y, z, w
  const most = four.indexOf(Math.max(...four)), s = 2 * Math.sqrt(four[most]!);
  const found: [number, number, number, number] = most === 0 ? [s / 4, (b + d) / s, (c + g) / s, (h - f) / s] : most === 1 ? [(b + d) / s, s / 4, (f + h) / s, (c - g) / s]
    : most === 2 ? [(c + g) / s, (f + h) / s, s / 4, (d - b) / s] : [(h - f) / s, (c - g) / s, (d - b) / s, s / 4];
  return found;
}
