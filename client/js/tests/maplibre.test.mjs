// ForelandLayer in headless Chromium, with the newest MapLibre and the oldest that is supported: ground lies where the map draws its places,
// seen from ten cameras; other 3D layers share its depths; credits are passed on; and a layer leaves nothing behind.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { complainOfWarnings, is_soak, makeFolder, makeSceneOnEarth, on_earth, openBrowser, openPage, package_folder, startServer } from './support.mjs';
import { serveFolder } from './static_server.mjs';

const kTest = { timeout: 600_000 };
let folder, server, files, browser;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeSceneOnEarth(folder.folder));
  files = await serveFolder(package_folder);
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  for (const one of [server, files]) await one?.stop();
  await folder?.remove();
});

// MapLibre 5 is no module: one is made of what its script leaves.
const oldest = `await new Promise((done, fail) => document.head.append(Object.assign(document.createElement('script'), {
  src: new URL('../../maplibre-gl-oldest/dist/maplibre-gl.js', import.meta.url).href, onload: done, onerror: fail })));
  export const { Map, MercatorCoordinate } = maplibregl;`;

// Runs `body` with the example; nothing may have gone wrong in it.
async function visit(body, { is_oldest = false } = {}) {
  const { page, complaints, close } = await openPage(browser, { width: 240, height: 160 });
  page.setDefaultTimeout(120_000);
  complainOfWarnings(page, complaints);
  if (is_oldest) await page.route('**/maplibre-gl/dist/maplibre-gl.mjs', (route) => route.fulfill({ contentType: 'text/javascript', body: oldest }));
  try {
    await page.goto(new URL(`examples/maplibre.html?server=${encodeURIComponent(server.url.href)}`, files.url).href);
    await page.waitForFunction(() => globalThis.layer?.ground?.drawn.version > 0, null, { polling: 50 });
    await page.evaluate(helpers);
    await body(page);
    assert.deepEqual(complaints, []);
  } finally {
    await close();
  }
}

// What the tests do in the page.
async function helpers() {
  const { MercatorCoordinate } = await import('maplibre-gl');
  const draw = layer.render;
  layer.render = function (gl, args) { // what the map gives last is kept
    globalThis.seen = args.defaultProjectionData;
    draw.call(layer, gl, args);
  };
  globalThis.picture = () => {
    map.redraw();
    const gl = map.getCanvas().getContext('webgl2');
    const bytes = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  };
  globalThis.differing = (a, b) => a.filter((v, i) => i % 4 < 3 && Math.abs(v - b[i]) > 8).length / a.length;
  // Until nothing new comes: the same mesh over several keyframes.
  // Waits until what is drawn stays and keeps to the tolerance: frames shown before the camera moved may state another one.
  globalThis.settle = async (tolerance = 1) => {
    for (let since = 0, last = ''; ;) {
      map.redraw();
      const now = JSON.stringify([layer.ground.drawn.triangles, layer.frame?.guaranteedPx, terrain.stats.tiles_received]);
      if (now !== last) since = terrain.stats.keyframes;
      last = now;
      const px = layer.frame?.guaranteedPx ?? Infinity;
      if (px <= tolerance && layer.ground.drawn.triangles > 0 && terrain.stats.keyframes > since + 6) return;
      await new Promise((done) => setTimeout(done, 20));
    }
  };
  // Where the map itself puts a place, in pixels from the lower left corner; null behind the camera.
  const canvas = map.getCanvas();
  const onSphere = (lon, lat, height) => {
    const [a, b, r] = [(lon * Math.PI) / 180, (lat * Math.PI) / 180, 1 + height / 6371008.8];
    return { x: r * Math.sin(a) * Math.cos(b), y: r * Math.sin(b), z: r * Math.cos(a) * Math.cos(b) };
  };
  globalThis.onScreen = ([lon, lat], height) => {
    const { x, y, z } = seen.projectionTransition > 0.5 ? onSphere(lon, lat, height) : MercatorCoordinate.fromLngLat([lon, lat], height), { mainMatrix: m } = seen;
    const p = [0, 1, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
    return p[2] <= 0 ? null : [0.5 * (p[0] / p[2] + 1) * canvas.width, 0.5 * (p[1] / p[2] + 1) * canvas.height, p[2]];
  };
  // Of each pixel: lattice, height, and whether there is ground.
  globalThis.groundPixels = () => {
    const { ground, scene, camera } = layer, material = ground.groundMaterial, renderer = ground.renderer;
    if (!material.tells_place) {
      const compile = material.onBeforeCompile;
      material.onBeforeCompile = (shader, ...rest) => {
        compile(shader, ...rest);
        shader.fragmentShader = shader.fragmentShader.replace('#include <dithering_fragment>', 'if (u_tells_place) gl_FragColor = vec4(v_lattice, v_texture_coordinate.w, 1.0);').replace('void main()', 'uniform bool u_tells_place;\nvoid main()');
        shader.uniforms.u_tells_place = material.tells_place;
      };
      material.customProgramCacheKey = () => 'tells place';
      material.tells_place = { value: false };
      material.needsUpdate = true;
    }
    const target = new ground.THREE.WebGLRenderTarget(canvas.width, canvas.height, { type: ground.THREE.FloatType });
    material.tells_place.value = true;
    renderer.resetState();
    renderer.setRenderTarget(target);
    renderer.clear();
    renderer.render(scene, camera);
    const texels = new Float32Array(4 * canvas.width * canvas.height);
    renderer.readRenderTargetPixels(target, 0, 0, canvas.width, canvas.height, texels);
    renderer.setRenderTarget(null);
    material.tells_place.value = false;
    target.dispose();
    return texels;
  };
  layer.ground.constructor.prototype.THREE = await import('three');
}

const kCameras = [
  { zoom: 9, pitch: 0, bearing: 0 }, { zoom: 12.3, pitch: 0, bearing: 77 }, { zoom: 9.5, pitch: 60, bearing: 200 }, { zoom: 11, pitch: 60, bearing: 0 },
  { zoom: 11.5, pitch: 75, bearing: 130 }, { zoom: 12, pitch: 80, bearing: -60 }, { zoom: 13, pitch: 70, bearing: 45, elevation: 1800 }, { zoom: 13.5, pitch: 45, bearing: -120, elevation: 1500 },
  { zoom: 12.5, pitch: 78, bearing: 90, padding: { left: 60, top: 20, right: 0, bottom: 0 } }, { zoom: 10.5, pitch: 80, bearing: 10 },
];

const kOnGlobe = [{ zoom: 7.5, pitch: 0, bearing: 20 }, { zoom: 9, pitch: 60, bearing: 0 }, { zoom: 10.5, pitch: 75, bearing: 200 }];

for (const is_oldest of [false, true])
  for (const projection of ['mercator', 'globe'])
    test(`ground is where the map draws its places: ${projection}, MapLibre ${is_oldest ? '5.0' : '6'}`, kTest, () =>
      visit(async (page) => {
        await page.evaluate((type) => (terrain.setOptions({ tolerancePx: 0.5 }), map.setCenterClampedToGround(false), map.setProjection({ type })), projection);
        let columns = 0;
        const cameras = projection === 'globe' ? kOnGlobe : kCameras;
        for (const camera of cameras.filter((_, i) => is_soak || (is_oldest ? i % 4 === 2 : i % 2 === 0))) {
          const told = await page.evaluate(measure, { camera, tolerance: 0.5, earth: { ...on_earth, heightOf: `${on_earth.heightOf}` } });
          const name = JSON.stringify(camera);
          assert.equal(told.is_globe, projection === 'globe');
          assert.ok(told.pixels > 500, `${name}: ${told.pixels} pixels of ground`);
          assert.ok(told.projected < 0.1, `${name}: ${told.projected} px from map.project`);
          assert.ok(told.worst < 0.2, `${name}: ground is ${told.worst} px off`);
          assert.ok(told.horizon <= 1, `${name}: the horizon is ${told.horizon} px off`);
          assert.ok(told.guaranteed <= 0.5, `${name}: ${told.guaranteed} px are guaranteed`);
          columns += told.columns;
        }
        assert.ok(columns > 200, `${columns} columns have a horizon`);
      }, { is_oldest }));

test('other 3D layers hide the ground and are hidden by it', kTest, () =>
  visit(async (page) => {
    const told = await page.evaluate(async () => {
      map.jumpTo({ center: [8.125, 46.125], zoom: 10, pitch: 50, bearing: 0 });
      await settle();
      const plain = picture();
      const share = (height) => {
        map.addSource('slab', { type: 'geojson', data: { type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [[[8.1, 46.1], [8.15, 46.1], [8.15, 46.15], [8.1, 46.15], [8.1, 46.1]]] } } });
        map.addLayer({ id: 'slab', type: 'fill-extrusion', source: 'slab', paint: { 'fill-extrusion-color': '#ff00ff', 'fill-extrusion-height': height } });
        return new Promise((done) => map.once('idle', () => {
          const found = differing(plain, picture());
          map.removeLayer('slab');
          map.removeSource('slab');
          done(found);
        }));
      };
      const shares = { below: await share(20), above: await share(4000) };
      layer.ground.visible = false;
      shares.ground = differing(plain, picture());
      layer.ground.visible = true;
      shares.again = differing(plain, picture());
      return shares;
    });
    assert.ok(told.ground > 0.2 && told.again < 0.001, JSON.stringify(told));
    assert.ok(told.below < 0.001, `a slab below the ground shows in ${told.below}`);
    assert.ok(told.above > 0.005, `a slab above it covers ${told.above}`);
  }));

test('credits stand on the map while the layer is there, and the layer leaves nothing behind', kTest, () =>
  visit(async (page) => {
    const told = await page.evaluate(async () => {
      const credits = () => [...document.querySelectorAll('.maplibregl-ctrl-attrib')].map((e) => e.textContent).filter((t) => /Painted by a test/.test(t)).length;
      await settle();
      while (credits() === 0) map.redraw(), await new Promise((done) => setTimeout(done, 20));
      const gl = map.getCanvas().getContext('webgl2');
      const live = new Map();
      for (const kind of ['Buffer', 'Texture', 'Framebuffer', 'VertexArray', 'Program', 'Shader']) {
        const [create, remove] = [gl[`create${kind}`], gl[`delete${kind}`]];
        gl[`create${kind}`] = function (...all) { const made = create.apply(this, all); live.set(made, kind); return made; };
        gl[`delete${kind}`] = function (gone) { live.delete(gone); return remove.call(this, gone); };
      }
      const counts = [];
      for (let i = 0; i < 12; ++i) {
        map.removeLayer('terrain');
        map.redraw();
        counts.push(live.size);
        if (credits() !== 0 || map.getLayer('terrain')) throw new Error('credits are still there');
        map.addLayer(layer);
        while (!(layer.ground.drawn.version > 0)) map.redraw(), await new Promise((done) => setTimeout(done, 5));
      }
      return { counts, error: gl.getError(), connected: terrain.isConnected };
    });
    assert.ok(told.counts.at(-1) <= told.counts[2], told.counts.join(' '));
    assert.equal(told.error, 0);
    assert.ok(told.connected);
  }));

// In the page: how far ground and horizon are from where the map puts them, in pixels.
async function measure({ camera, tolerance, earth: { size, west, south, step, heightOf } }) {
  const heightAt = eval(heightOf);
  map.jumpTo({ center: [8.125, 46.125], padding: { left: 0, top: 0, right: 0, bottom: 0 }, elevation: 0, ...camera });
  await settle(tolerance);
  const { width, height } = map.getCanvas(), texels = groundPixels(), pivot = layer.ground.uniforms.u_pivot.value;
  const told = { is_globe: seen.projectionTransition > 0.5, pixels: 0, worst: 0, projected: 0, horizon: 0, columns: 0, guaranteed: layer.frame.guaranteedPx };
  const tops = new Array(width).fill(-1);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const [i, j, h, is_ground] = texels.subarray(4 * (y * width + x));
      if (is_ground === 0) continue;
      ++told.pixels;
      tops[x] = y + 1;
      const at = onScreen([west + step * (i + pivot.x), south + step * (j + pivot.y)], h);
      told.worst = Math.max(told.worst, Math.hypot(at[0] - x - 0.5, at[1] - y - 0.5));
    }
  const middle = [8.12, 46.13], { x, y } = map.project(middle), own = onScreen(middle, camera.elevation ?? 0), ratio = width / map.getContainer().clientWidth;
  told.projected = Math.hypot(own[0] - x * ratio, height - own[1] - y * ratio);
  // The highest of all edges between samples in each column.
  const points = [];
  for (let j = 0; j < size; ++j) for (let i = 0; i < size; ++i) points.push(onScreen([west + step * i, south + step * j], heightAt(i, j)));
  const expected = new Array(width).fill(-Infinity);
  const edge = (a, b) => {
    if (!a || !b) return;
    if (a[0] > b[0]) [a, b] = [b, a];
    for (let c = Math.max(0, Math.ceil(a[0] - 0.5)); c + 0.5 <= b[0] && c < width; ++c)
      expected[c] = Math.max(expected[c], a[1] + ((b[1] - a[1]) * (c + 0.5 - a[0])) / (b[0] - a[0] || 1));
  };
  for (let j = 0; j < size; ++j)
    for (let i = 0; i < size; ++i) {
      if (i + 1 < size) edge(points[j * size + i], points[j * size + i + 1]);
      if (j + 1 < size) edge(points[j * size + i], points[(j + 1) * size + i]);
      if (i + 1 < size && j + 1 < size) edge(points[j * size + i], points[(j + 1) * size + i + 1]);
    }
  for (let c = 1; c + 1 < width; ++c) {
    const near = expected.slice(c - 1, c + 2).map((v) => Math.min(v, height));
    const [low, high] = [Math.min(...near), Math.max(...near)];
    if (!(low > 0) || tops[c] < 0 || low >= height) continue;
    ++told.columns;
    told.horizon = Math.max(told.horizon, low - tops[c], tops[c] - high);
  }
  return told;
}
