// MapLibre GL JS with terrain of terrain-RGB tiles, and nothing on it but a background. Its terrain is drawn in Mercator's plane; the
// judge takes longitude, latitude and height of what it draws, and puts them on the earth.
import { Map as MapLibre, setWorkerUrl } from 'maplibre-gl';
import { axesOf } from '../earth.mjs';

const kCells = 128; // of a tile's mesh, a side

export async function open({ earth, plan, lens, size, quality, tiles }) {
  if (setWorkerUrl) setWorkerUrl('/packages/maplibre-gl/dist/maplibre-gl-worker.mjs');
  const place = Object.assign(document.createElement('div'), { style: `width:${size.width}px;height:${size.height}px` });
  document.body.append(place);
  const map = new MapLibre({
    container: place, interactive: false, attributionControl: false, maxPitch: 180, fadeDuration: 0, pixelRatio: 1,
    center: plan.ground.origin_deg, zoom: 10, style: { version: 8, sources: {}, layers: [{ id: 'background', type: 'background', paint: { 'background-color': '#888' } }] },
  });
  await new Promise((done) => map.once('load', done));
  map.setVerticalFieldOfView((lens.fov_rad * 180) / Math.PI);
  map.setCenterClampedToGround(false);
  let is_idle = false, has_begun = false;
  map.on('idle', () => void (is_idle = has_begun));
  return {
    begin(pose) {
      has_begun = true;
      look(pose);
      // Tiles are asked for by their size on the canvas, which is so much smaller than the lens. A quality of q is a texel of q pixels of the lens.
      map.addSource('ground', { type: 'raster-dem', tiles: [`${tiles}terrain-rgb/{z}/{x}/{y}.webp`], encoding: 'mapbox', tileSize: (quality * 256 * size.height) / lens.height_px, ...plan.terrain_rgb });
      map.setTerrain({ source: 'ground' });
    },
    show(pose) {
      if (!has_begun) return;
      is_idle = false;
      look(pose);
      map.redraw();
    },
    isComplete: () => is_idle,
    snapshot() {
      const { tileManager } = map.terrain;
      return tileManager.getRenderableTiles().map(({ tileID }) => {
        const source = tileManager.getSourceTile(tileID, true);
        return { z: tileID.canonical.z, x: tileID.canonical.x, y: tileID.canonical.y, dem: source?.dem ?? null, of: source?.tileID.canonical };
      });
    },
    meshesOf: (snapshot) => snapshot.map(meshOf),
  };

  function look({ eye, orientation }) {
    const at = earth.sceneToEcef(eye), [lon, lat, height] = earth.toGeodetic(at), { up, forward } = axesOf(orientation);
    const [ahead, above] = [forward, up].map((v) => levelled(earth.turnToEcef(v), lon, lat));
    const pitch = Math.acos(Math.max(-1, Math.min(1, -ahead[2])));
    const bearing = Math.hypot(ahead[0], ahead[1]) > 1e-9 ? Math.atan2(ahead[0], ahead[1]) : Math.atan2(above[0], above[1]);
    const degrees = (v) => (v * 180) / Math.PI;
    map.jumpTo(map.calculateCameraOptionsFromCameraLngLatAltRotation([degrees(lon), degrees(lat)], height, degrees(bearing), degrees(pitch)));
  }

  // East, north and up where the camera is.
  function levelled([x, y, z], lon, lat) {
    const [s, c, a, b] = [Math.sin(lon), Math.cos(lon), Math.sin(lat), Math.cos(lat)];
    return [-s * x + c * y, -a * c * x - a * s * y + b * z, b * c * x + b * s * y + a * z];
  }

  // Two triangles a cell, whose common edge goes from its north-western to its south-eastern corner.
  function meshOf({ z, x: tile_x, y: tile_y, dem, of }) {
    const across = 2 ** z;
    const corner = (i, j) => {
      if (!dem) return 0;
      const shift = z - of.z, n = 2 ** shift, pixel = (k, tile) => ((k / kCells + (tile % n)) / n) * dem.dim - 0.5;
      return dem.sampleBilinear(pixel(i, tile_x), pixel(j, tile_y));
    };
    return {
      triangles: 2 * kCells * kCells,
      drawnAt(lon, lat) {
        const mx = 0.5 + lon / (2 * Math.PI), my = 0.5 - Math.asinh(Math.tan(lat)) / (2 * Math.PI);
        const u = (mx * across - tile_x) * kCells, v = (my * across - tile_y) * kCells;
        if (u < 0 || v < 0 || u > kCells || v > kCells) return null;
        const i = Math.min(kCells - 1, Math.floor(u)), j = Math.min(kCells - 1, Math.floor(v)), [p, q] = [u - i, v - j];
        const [first, last] = [corner(i, j), corner(i + 1, j + 1)];
        const height = p > q ? first * (1 - p) + corner(i + 1, j) * (p - q) + last * q : first * (1 - q) + corner(i, j + 1) * (q - p) + last * p;
        return earth.ecefToScene(earth.toEcef(lon, lat, height));
      },
    };
  }
}
