// The camera of a map, of the matrix that the map draws with: from Mercator's square, or from a unit sphere, to the screen. Nothing else
// that a map tells of its camera is needed, so this holds whatever turns, pads or lifts it. Numbers are doubles throughout.

/** @internal Of MapLibre's earth, metres. */
export const kMapRadius = 6371008.8;

/** @internal A map's camera, in metres eastward, northward and up from the zero surface below the eye. */
export interface MapCamera {
  /** Below the eye, radians. */
  latitude: number;
  longitude: number;
  /** Of the eye, metres. */
  height: number;
  /** Rightward, upward and backward: columns of the camera's turn. */
  axes: readonly [Triple, Triple, Triple];
  /** From the camera's axes to clip coordinates, 16 numbers by columns. */
  projection: number[];
  /** Tangents of the angles from the camera's axis to the picture's left, right, lower and upper edge; those on either side are positive. */
  edges: { left: number; right: number; down: number; up: number };
}
type Triple = readonly [number, number, number];

const dot = (a: Triple, b: Triple) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Triple, b: Triple): Triple => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a: Triple, s: number): Triple => [a[0] * s, a[1] * s, a[2] * s];
const minus = (a: Triple, b: Triple): Triple => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const unit = (a: Triple) => scaled(a, 1 / Math.sqrt(dot(a, a)));

interface Row { across: Triple; shift: number }
const rowOf = (m: ArrayLike<number>, i: number): Row => ({ across: [m[i]!, m[4 + i]!, m[8 + i]!], shift: m[12 + i]! });

// Where x, y and w are 0.
function eyeOf(m: ArrayLike<number>): Triple {
  const [a, b, c] = [rowOf(m, 0), rowOf(m, 1), rowOf(m, 3)];
  const bc = cross(b.across, c.across), ca = cross(c.across, a.across), ab = cross(a.across, b.across);
  const volume = dot(a.across, bc);
  return [0, 1, 2].map((i) => -(a.shift * bc[i]! + b.shift * ca[i]! + c.shift * ab[i]!) / volume) as unknown as Triple;
}

interface Local { latitude: number; longitude: number; height: number; origin: Triple; basis: readonly [Triple, Triple, Triple] }

// Metres at a place of Mercator's square, which is 1 wide, and whose y goes southward.
function localOnSquare([x, y, z]: Triple): Local {
  const longitude = (2 * x - 1) * Math.PI, latitude = Math.atan(Math.sinh((1 - 2 * y) * Math.PI));
  const unit = 1 / (2 * Math.PI * kMapRadius * Math.cos(latitude));
  return { latitude, longitude, height: z / unit, origin: [x, y, 0], basis: [[unit, 0, 0], [0, -unit, 0], [0, 0, unit]] };
}
// Metres at a place of the unit sphere, whose y goes to the north pole and whose z to longitude 0.
function localOnSphere(eye: Triple): Local {
  const distance = Math.sqrt(dot(eye, eye)), up = scaled(eye, 1 / distance);
  const longitude = Math.atan2(eye[0], eye[2]), latitude = Math.asin(up[1]);
  const east: Triple = [Math.cos(longitude), 0, -Math.sin(longitude)];
  const of = (axis: Triple) => scaled(axis, 1 / kMapRadius);
  return { latitude, longitude, height: (distance - 1) * kMapRadius, origin: up, basis: [of(east), of(cross(up, east)), of(up)] };
}

/** @internal The camera of a matrix from Mercator's square, or, of a globe, from the unit sphere. */
export function cameraOfMap(matrix: ArrayLike<number>, is_globe: boolean): MapCamera {
  const eye = eyeOf(matrix);
  const { latitude, longitude, height, origin, basis } = is_globe ? localOnSphere(eye) : localOnSquare(eye);
  const rows = [0, 1, 2, 3].map((i) => {
    const { across, shift } = rowOf(matrix, i);
    return { across: basis.map((axis) => dot(axis, across)) as unknown as Triple, shift: shift + dot(origin, across) };
  }) as [Row, Row, Row, Row];
  const w = rows[3], length = Math.sqrt(dot(w.across, w.across)), forward = scaled(w.across, 1 / length);
  const rightward = unit(minus(rows[0].across, scaled(forward, dot(rows[0].across, forward))));
  const axes = [rightward, cross(rightward, forward), scaled(forward, -1)] as const;
  const projection: number[] = [];
  for (const axis of axes) projection.push(...rows.map((row) => dot(row.across, axis) / length));
  projection.push(...rows.map((row, i) => (i === 2 ? (row.shift + height * row.across[2]) / length : 0))); // the others are 0 at the eye
  const [wide, high, x, y] = [projection[0]!, projection[5]!, projection[8]!, projection[9]!];
  return { latitude, longitude, height, axes, projection, edges: { left: (1 - x) / wide, right: (1 + x) / wide, down: (1 - y) / high, up: (1 + y) / high } };
}

/** @internal An ellipsoid: half its longer axis, metres, and its eccentricity squared. */
export interface Ellipsoid {
  semi_major_m: number;
  eccentricity_squared: number;
}

/** @internal What is curved how at a latitude: distance from the earth's axis, radius of the meridian's curve, and its growth northward. */
export function curvesAt(latitude: number, { semi_major_m, eccentricity_squared: e2 }: Ellipsoid): { axis: number; meridian: number; growth: number } {
  const s = Math.sin(latitude), c = Math.cos(latitude), q = 1 - e2 * s * s;
  return { axis: (semi_major_m / Math.sqrt(q)) * c, meridian: (semi_major_m * (1 - e2)) / (q * Math.sqrt(q)), growth: (3 * e2 * s * c) / q };
}

/** @internal From the earth's axes to metres east, north and up from the zero surface at a place: 16 numbers by columns. */
export function localOfEarth(latitude: number, longitude: number, { semi_major_m, eccentricity_squared: e2 }: Ellipsoid): number[] {
  const [s, c, sl, cl] = [Math.sin(latitude), Math.cos(latitude), Math.sin(longitude), Math.cos(longitude)];
  const across = semi_major_m / Math.sqrt(1 - e2 * s * s);
  const at: Triple = [across * c * cl, across * c * sl, across * (1 - e2) * s];
  const axes: readonly Triple[] = [[-sl, cl, 0], [-s * cl, -s * sl, c], [c * cl, c * sl, s]];
  return [0, 1, 2].flatMap((i) => [...axes.map((axis) => axis[i]!), 0]).concat(axes.map((axis) => -dot(axis, at)), 1);
}
