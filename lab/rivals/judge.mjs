// The one judge of all that is drawn, ours and others': for points of the true ground that a camera sees, where they are drawn. True
// and drawn points correspond by longitude and latitude, as everywhere here, and are apart so many pixels of the lens. What was
// drawn is given as triangles, as they were on the card, so the judge itself errs by rounding alone: less than 0.001 px. Between the
// points it sees nothing, so its largest error is at most the true one. Node and pages; pure.
import { axesOf } from './earth.mjs';

export function cameraOf({ eye, orientation }, { fov_rad, width_px, height_px }) {
  const { right, up, forward } = axesOf(orientation), focal = (0.5 * height_px) / Math.tan(0.5 * fov_rad);
  const dot = (a, x, y, z) => a[0] * x + a[1] * y + a[2] * z;
  return {
    eye, width_px, height_px,
    // Pixels from the middle; null where it is not a metre before the eye.
    project([x, y, z]) {
      const [a, b, c] = [x - eye[0], y - eye[1], z - eye[2]], depth = dot(forward, a, b, c);
      return depth > 1 ? [(focal * dot(right, a, b, c)) / depth, (focal * dot(up, a, b, c)) / depth] : null;
    },
    ray: (x, y) => [0, 1, 2].map((i) => forward[i] + (right[i] * x + up[i] * y) / focal),
  };
}

export const isInPicture = (camera, at) => at !== null && Math.abs(at[0]) <= 0.5 * camera.width_px && Math.abs(at[1]) <= 0.5 * camera.height_px;

// Samples of the ground where the rays of a grid of pixels meet it first. Each is a place (lon, lat) and where it is in the scene's axes.
export function pointsSeen(camera, ground, earth, { columns = 32, rows = 18, far_m = 150e3 } = {}) {
  const points = [];
  for (let j = 0; j < rows; ++j)
    for (let i = 0; i < columns; ++i) {
      const hit = firstHit(camera, camera.ray((camera.width_px * (i + 0.5)) / columns - 0.5 * camera.width_px, (camera.height_px * (j + 0.5)) / rows - 0.5 * camera.height_px), ground, earth, far_m);
      const sample = hit && ground.nearest(hit[0], hit[1]);
      if (!sample) continue;
      const scene = earth.ecefToScene(earth.toEcef(...sample));
      if (isInPicture(camera, camera.project(scene))) points.push({ lon: sample[0], lat: sample[1], scene });
    }
  return points;
}

// Steps of a two hundred and fiftieth of the distance, and at least a fifth of a sample.
function firstHit(camera, direction, ground, earth, far_m) {
  const length = Math.hypot(...direction), least_m = 0.2 * 6.37e6 * Math.min(ground.dx, ground.dy);
  for (let t = 1; t < far_m; t += Math.max(least_m, 0.004 * t)) {
    const place = earth.toGeodetic(earth.sceneToEcef(camera.eye.map((v, i) => v + (direction[i] * t) / length)));
    if (place[2] > 9000 && direction[2] > 0) return null;
    if (place[0] < ground.west || place[0] > ground.east || place[1] < ground.south || place[1] > ground.north) continue;
    if (place[2] <= ground.heightAt(place[0], place[1])) return place;
  }
  return null;
}

// A mesh to be asked where it is drawn at a place. `places` has longitude and latitude of each vertex, `scene` its position.
export function indexMesh({ places, scene, indices }) {
  let [west, south, east, north] = [Infinity, Infinity, -Infinity, -Infinity];
  const hasArea = (t) => indices[t] !== indices[t + 1] && indices[t + 1] !== indices[t + 2]; // buffers that change in place hold others
  let triangles = 0;
  for (let t = 0; t < indices.length; t += 3) {
    if (!hasArea(t)) continue;
    ++triangles;
    for (let k = 2 * indices[t], corner = 0; corner < 3; k = 2 * indices[t + ++corner]) {
      west = Math.min(west, places[k]), east = Math.max(east, places[k]);
      south = Math.min(south, places[k + 1]), north = Math.max(north, places[k + 1]);
    }
  }
  const side = Math.max(1, Math.min(1024, Math.ceil(Math.sqrt(indices.length / 6))));
  const cellX = (lon) => Math.min(side - 1, Math.max(0, Math.floor(((lon - west) / (east - west)) * side)));
  const cellY = (lat) => Math.min(side - 1, Math.max(0, Math.floor(((lat - south) / (north - south)) * side)));
  // Of each cell the triangles that reach into it: counted, then filled.
  const ends = new Uint32Array(side * side + 1);
  eachCell((cell) => ++ends[cell + 1]);
  for (let cell = 0; cell < side * side; ++cell) ends[cell + 1] += ends[cell];
  const filled = ends.slice(), held = new Uint32Array(ends[side * side]);
  eachCell((cell, t) => void (held[filled[cell]++] = t));
  const slack = 1e-9 * Math.max(east - west, north - south);
  return {
    triangles,
    // The highest point that is drawn there, in the scene's axes; null where there is none.
    drawnAt(lon, lat) {
      if (lon < west - slack || lon > east + slack || lat < south - slack || lat > north + slack) return null;
      let best = null;
      for (let cell = cellY(lat) * side + cellX(lon), k = ends[cell]; k < ends[cell + 1]; ++k) {
        const t = held[k], p = pointIn(lon, lat, indices[t], indices[t + 1], indices[t + 2]);
        if (p && (!best || p[2] > best[2])) best = p;
      }
      return best;
    },
  };

  function eachCell(visit) {
    for (let t = 0; t < indices.length; t += 3) {
      if (!hasArea(t)) continue;
      const [a, b, c] = [2 * indices[t], 2 * indices[t + 1], 2 * indices[t + 2]];
      const x0 = cellX(Math.min(places[a], places[b], places[c])), x1 = cellX(Math.max(places[a], places[b], places[c]));
      const y0 = cellY(Math.min(places[a + 1], places[b + 1], places[c + 1])), y1 = cellY(Math.max(places[a + 1], places[b + 1], places[c + 1]));
      for (let y = y0; y <= y1; ++y) for (let x = x0; x <= x1; ++x) visit(y * side + x, t);
    }
  }

  function pointIn(lon, lat, a, b, c) {
    const [ax, ay] = [places[2 * a] - lon, places[2 * a + 1] - lat], [bx, by] = [places[2 * b] - lon, places[2 * b + 1] - lat], [cx, cy] = [places[2 * c] - lon, places[2 * c + 1] - lat];
    const [u, v, w] = [bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], sum = u + v + w;
    const least = -1e-7 * Math.abs(sum);
    if (sum === 0 || (sum > 0 ? Math.min(u, v, w) < least : Math.max(u, v, w) > -least)) return null;
    return [0, 1, 2].map((i) => (u * scene[3 * a + i] + v * scene[3 * b + i] + w * scene[3 * c + i]) / sum);
  }
}

// Where all of the meshes together draw a place.
export function drawnBy(meshes, { lon, lat }) {
  let best = null;
  for (const mesh of meshes) {
    const p = mesh.drawnAt(lon, lat);
    if (p && (!best || p[2] > best[2])) best = p;
  }
  return best;
}

// Of points that the camera has in its picture: how far two places of each are apart in it. `from` and `to` give a point's, or null.
export function compare(camera, points, from, to) {
  let [squares, largest, seen, uncovered] = [0, 0, 0, 0];
  for (const point of points) {
    if (!isInPicture(camera, camera.project(point.scene))) continue;
    const [a, b] = [from(point), to(point)], [p, q] = [a && camera.project(a), b && camera.project(b)];
    if (!p || !q) { ++uncovered; continue; }
    const px = Math.hypot(p[0] - q[0], p[1] - q[1]);
    squares += px * px, largest = Math.max(largest, px), ++seen;
  }
  return { squares, largest, seen, uncovered };
}
