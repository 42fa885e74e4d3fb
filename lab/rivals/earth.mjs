// The earth and a scene's axes on it, in node and in pages. Longitudes and latitudes in radians, lengths in metres; positions are
// arrays of three. Pure.

// `ground` as flight_plan.h writes it: the ellipsoid, and the origin at which the scene's axes are east, north and up.
export function earthOf({ semi_major_m: a, flattening: f, origin_deg, origin_height_m }) {
  const e2 = f * (2 - f), b = a * (1 - f), ep2 = (a * a) / (b * b) - 1;
  const toEcef = (lon, lat, height) => {
    const [s, c] = [Math.sin(lat), Math.cos(lat)], n = a / Math.sqrt(1 - e2 * s * s);
    return [(n + height) * c * Math.cos(lon), (n + height) * c * Math.sin(lon), (n * (1 - e2) + height) * s];
  };
  // Bowring's formula, twice: to 1e-6 m within 100 km of the ellipsoid, away from the poles.
  const toGeodetic = ([x, y, z]) => {
    const p = Math.hypot(x, y);
    let t = Math.atan2(z * a, p * b), lat = 0;
    for (let i = 0; i < 2; ++i) {
      lat = Math.atan2(z + ep2 * b * Math.sin(t) ** 3, p - e2 * a * Math.cos(t) ** 3);
      t = Math.atan2(b * Math.sin(lat), a * Math.cos(lat));
    }
    const s = Math.sin(lat), n = a / Math.sqrt(1 - e2 * s * s);
    return [Math.atan2(y, x), lat, p * Math.cos(lat) + z * s - n * (1 - e2 * s * s)];
  };
  const [lon0, lat0] = origin_deg.map((v) => (v * Math.PI) / 180), origin = toEcef(lon0, lat0, origin_height_m);
  const [sx, cx, sy, cy] = [Math.sin(lon0), Math.cos(lon0), Math.sin(lat0), Math.cos(lat0)];
  const axes = [[-sx, cx, 0], [-sy * cx, -sy * sx, cy], [cy * cx, cy * sx, sy]]; // east, north, up
  const turnToEcef = (v) => [0, 1, 2].map((i) => axes[0][i] * v[0] + axes[1][i] * v[1] + axes[2][i] * v[2]);
  const sceneToEcef = (p) => turnToEcef(p).map((v, i) => v + origin[i]);
  const ecefToScene = (p) => {
    const d = [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
    return axes.map((axis) => axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2]);
  };
  return { radii: [a, a, b], origin, axes, toEcef, toGeodetic, turnToEcef, sceneToEcef, ecefToScene };
}

// A camera looks along -z of its axes, with y up.
export function axesOf([x, y, z, w]) {
  const turn = ([u, v, t]) => {
    const [a, b, c] = [2 * (y * t - z * v), 2 * (z * u - x * t), 2 * (x * v - y * u)];
    return [u + w * a + y * c - z * b, v + w * b + z * a - x * c, t + w * c + x * b - y * a];
  };
  return { right: turn([1, 0, 0]), up: turn([0, 1, 0]), forward: turn([0, 0, -1]) };
}
