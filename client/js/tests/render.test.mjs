// The picture in Chromium beside that of `foreland render --section`, which casts rays at the section for the same pose. The looks of both
// differ in principle: the ground's standard material has three's lights, mottling and normals by relief, and no haze. So it is drawn here
// with a material that has the light and colours of `foreland render` (terrain/render/shading.cpp) on flat triangles, of the package's own
// parts of shaders; what is compared is where ground is, how it is turned and how high it is.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { complainOfWarnings, makeFolder, makeScene, makeSceneOnEarth, openBrowser, openPage, package_folder, runForeland, startServer } from './support.mjs';
import { serveFolder } from './static_server.mjs';

const kTest = { timeout: 600_000 };
let folder, files, browser;

before(async () => {
  folder = await makeFolder();
  files = await serveFolder(package_folder);
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  await files?.stop();
  await folder?.remove();
});

const kSize = { width: 320, height: 200 };

for (const [name, make] of [['on a map', (at) => makeScene(at, { size: 257 })], ['on the earth', makeSceneOnEarth]])
  test(`a scene ${name} looks as by foreland render`, kTest, async () => {
    const scene = await make(folder.folder);
    const server = await startServer(scene);
    const { page, complaints, close } = await openPage(browser, kSize);
    complainOfWarnings(page, complaints);
    page.setDefaultTimeout(120_000);
    try {
      await page.goto(new URL(`examples/three-basic.html?server=${encodeURIComponent(server.url.href)}`, files.url).href);
      await page.waitForFunction(() => globalThis.ground?.drawn.version > 0, null, { polling: 50 });
      const poses = await page.evaluate(prepare);
      for (const [i, pose] of poses.entries()) {
        const file = join(folder.folder, `${name}${i}.png`);
        await runForeland('render', scene, '--pose', pose.words, '--viewport', `${kSize.width}x${kSize.height}`, '--fov', '60', '--section', '--tau', '1', '-o', file);
        const told = await page.evaluate(compare, { pose, png: (await readFile(file)).toString('base64') });
        if (process.env.SHOW) console.log(pose.words, JSON.stringify(told));
        assert.ok(told.ground > 0.3 * kSize.width * kSize.height, `${pose.words}: ground on ${told.ground} pixels`);
        assert.ok(told.sky > 500, `${pose.words}: sky on ${told.sky} pixels`);
        assert.equal(told.astray, 0, `${pose.words}: ground where there is none`);
        assert.equal(told.missing, 0, `${pose.words}: no ground where there is some`);
        assert.ok(told.median <= 2, `${pose.words}: brightness differs by ${told.median} of 255`);
      }
      assert.deepEqual(complaints, []);
    } finally {
      await close();
      await server.stop();
    }
  });

// In the page: draws with the light and the colours of `foreland render`. Gives poses to compare at.
async function prepare() {
  const { ForelandTerrain, glsl } = await import('@foreland/client/three');
  renderer.setAnimationLoop(null);
  ground.dispose();
  const { low, high } = terrain.scene.bounds, { samples } = terrain.scene;
  globalThis.haze = { value: 1 };
  const kSky = `uniform float u_haze_m;
    vec3 skyAt(float height) { return mix(vec3(0.36, 0.50, 0.68), vec3(0.030, 0.105, 0.310), 1.0 - exp(-5.5 * max(height, 0.0))); }`;
  const kVertex = `uniform mat4 modelViewMatrix, projectionMatrix;
    uniform vec3 u_origin;
    out vec3 v_from_eye;
    void main() { vec4 p = blended(); v_from_eye = p.xyz + u_origin; passGround(p); gl_Position = projectionMatrix * (modelViewMatrix * vec4(p.xyz, 1.0)); }`;
  const kFragment = `in vec3 v_from_eye;
    out vec4 o_colour;
    const vec3 kColours[6] = vec3[](vec3(0.044, 0.084, 0.039), vec3(0.089, 0.141, 0.060), vec3(0.205, 0.202, 0.091), vec3(0.223, 0.147, 0.084), vec3(0.159, 0.125, 0.102), vec3(0.314, 0.292, 0.271));
    void main() {
      vec3 normal = normalize(cross(dFdx(v_from_eye), dFdy(v_from_eye))), up = upAt(v_lattice);
      float t = (v_texture_coordinate.w - u_heights.x) / (u_heights.y - u_heights.x), steepness = 1.0 - dot(normal, up), at = clamp(t, 0.0, 1.0) * 5.0;
      int i = min(int(at), 4);
      vec3 bare = mix(mix(kColours[i], kColours[i + 1], smoothstep(0.0, 1.0, at - float(i))), vec3(0.15, 0.13, 0.115), smoothstep(0.20, 0.42, steepness));
      vec3 albedo = mix(bare, vec3(0.80, 0.84, 0.90), smoothstep(0.70, 0.80, t) * (1.0 - smoothstep(0.26, 0.44, steepness)));
      vec3 light = vec3(2.15, 1.92, 1.56) * max(dot(normal, normalize(vec3(-0.5714, 0.5714, 0.589))), 0.0)
        + mix(vec3(0.09, 0.08, 0.07), vec3(0.17, 0.24, 0.36), 0.5 + 0.5 * dot(normal, up));
      vec3 x = 0.80 * mix(skyAt(0.0), albedo * light, exp(-length(v_from_eye) / u_haze_m));
      vec3 film = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
      o_colour = vec4(mix(12.92 * film, 1.055 * pow(film, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, film)), 1.0);
    }`;
  const plain = (uniforms) => new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, uniforms: { ...uniforms, u_haze_m: haze },
    vertexShader: `precision highp float;\n${glsl.interpolation}${glsl.groundVertex}${kVertex}`,
    fragmentShader: `precision highp float; precision highp int; precision highp sampler2DArray; precision highp usampler2D;\n${glsl.common}${glsl.tiles}${glsl.ground}${kSky}${kFragment}` });
  const invisible = () => new THREE.MeshBasicMaterial({ visible: false });
  globalThis.looked = new ForelandTerrain(terrain, { renderer, materials: { ground: plain, object: () => ({ material: invisible(), setImage() {} }), lines: invisible } });
  scene.add(looked);
  Object.assign(camera, { fov: 60, aspect: 1.6 });
  terrain.setOptions({ tolerancePx: 1, relief: false });
  // The corners of the data, of which the haze's distance comes.
  const placeAt = (point) => terrain.toGeodetic(point);
  const middle = placeAt([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0]);
  const is_on_earth = 'lon' in middle, pick = (p) => (is_on_earth ? [p.lat, p.lon] : [p.easting, p.northing]);
  const other = placeAt([0.5 * low[0], 0.5 * low[1], 0]);
  const per = [0, 1].map((k) => { // of the map, in a sample
    const axis = is_on_earth ? 1 - k : k;
    return (pick(middle)[axis] - pick(other)[axis]) / (middle.lattice[k] - other.lattice[k]);
  });
  const atSample = (i, j) => {
    const across = [i, j].map((v, k) => pick(middle)[is_on_earth ? 1 - k : k] + (v - middle.lattice[k]) * per[k]);
    return is_on_earth ? { lon: across[0], lat: across[1] } : { easting: across[0], northing: across[1] };
  };
  const [a, b] = [atSample(0, 0), atSample(samples[0] - 1, samples[1] - 1)].map((p) => terrain.toScene(p));
  haze.value = Math.hypot(...a.map((v, i) => v - b[i]));
  return [[0.5, 0.2, 600, 0, -8], [0.15, 0.15, 300, 45, -3], [0.8, 0.7, 1500, -130, -25]].map(([x, y, height, heading, pitch]) => {
    const place = atSample(Math.round(x * samples[0]), Math.round(y * samples[1]));
    const words = [...(is_on_earth ? [place.lat, place.lon] : [place.easting, place.northing]).map((v) => v.toFixed(9)), height, heading, pitch].join(',');
    return { place, height, heading, pitch, words };
  });
}

// In the page: how the picture at a pose differs from another one.
async function compare({ pose: { place, height, heading, pitch }, png }) {
  const [ground_m] = await terrain.heights([place]);
  const eye = terrain.toScene({ ...place, height: ground_m + height });
  const up = new THREE.Vector3(...terrain.toGeodetic(eye).up), [h, p] = [heading, pitch].map((degrees) => (degrees * Math.PI) / 180);
  const pole = terrain.scene.toEcef ? new THREE.Vector3(terrain.scene.toEcef[2], terrain.scene.toEcef[6], terrain.scene.toEcef[10]) : new THREE.Vector3(0, 1, 0);
  const east = pole.cross(up).normalize(), north = up.clone().cross(east);
  camera.position.fromArray(eye);
  camera.up.copy(up);
  camera.lookAt(camera.position.clone().addScaledVector(east, Math.sin(h) * Math.cos(p)).addScaledVector(north, Math.cos(h) * Math.cos(p)).addScaledVector(up, Math.sin(p)));
  const { width, height: rows } = renderer.domElement, target = new THREE.WebGLRenderTarget(width, rows), bytes = new Uint8Array(4 * width * rows);
  renderer.setRenderTarget(target);
  renderer.setClearColor(0, 0);
  scene.background = null;
  Object.assign(camera, looked.depthRange(eye));
  camera.updateProjectionMatrix();
  terrain.jump();
  for (let since = 0, last = ''; ;) {
    const frame = looked.update(camera, performance.now());
    renderer.render(scene, camera);
    const now = JSON.stringify([looked.drawn.triangles, frame.guaranteedPx]);
    if (now !== last) since = terrain.stats.keyframes;
    last = now;
    if (frame.guaranteedPx !== null && looked.drawn.triangles > 0 && terrain.stats.keyframes > since + 8) break;
    await new Promise((done) => setTimeout(done, 20));
  }
  renderer.readRenderTargetPixels(target, 0, 0, width, rows, bytes);
  renderer.setRenderTarget(null);
  target.dispose();
  // Theirs, which has no mark for the sky but its colour.
  const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
  const context = Object.assign(document.createElement('canvas'), { width, height: rows }).getContext('2d', { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  const theirs = context.getImageData(0, 0, width, rows).data;
  const toScreen = (v) => {
    const x = 0.8 * v, film = Math.min(Math.max((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0), 1);
    return 255 * (film < 0.0031308 ? 12.92 * film : 1.055 * film ** (1 / 2.4) - 0.055);
  };
  const direction = new THREE.Vector3();
  const isSky = (x, y) => {
    direction.set(((x + 0.5) / width) * 2 - 1, 1 - ((y + 0.5) / rows) * 2, 0.5).unproject(camera).sub(camera.position).normalize();
    const share = 1 - Math.exp(-5.5 * Math.max(direction.dot(up), 0));
    return [[0.36, 0.03], [0.5, 0.105], [0.68, 0.31]].every(([low, high], k) => Math.abs(theirs[4 * (y * width + x) + k] - toScreen(low + (high - low) * share)) <= 1.5);
  };
  const theirs_is_sky = Array.from({ length: width * rows }, (_, at) => isSky(at % width, Math.floor(at / width)));
  const is_ground = Array.from({ length: width * rows }, (_, at) => bytes[4 * ((rows - 1 - Math.floor(at / width)) * width + (at % width)) + 3] > 0);
  // Whether there is none of it within a pixel.
  const isAlone = (which, at) => {
    const [x, y] = [at % width, Math.floor(at / width)];
    for (let v = Math.max(0, y - 1); v <= Math.min(rows - 1, y + 1); ++v) for (let u = Math.max(0, x - 1); u <= Math.min(width - 1, x + 1); ++u) if (which(v * width + u)) return false;
    return true;
  };
  const told = { ground: 0, sky: 0, astray: 0, missing: 0 }, differences = [];
  for (let at = 0; at < width * rows; ++at) {
    if (theirs_is_sky[at]) ++told.sky;
    if (is_ground[at]) ++told.ground;
    if (is_ground[at] && theirs_is_sky[at] && isAlone((i) => !theirs_is_sky[i], at)) ++told.astray;
    if (!is_ground[at] && !theirs_is_sky[at] && isAlone((i) => is_ground[i], at)) ++told.missing;
    if (!is_ground[at] || theirs_is_sky[at]) continue;
    const mine = 4 * ((rows - 1 - Math.floor(at / width)) * width + (at % width));
    const bright = (rgb, i) => 0.2126 * rgb[i] + 0.7152 * rgb[i + 1] + 0.0722 * rgb[i + 2];
    differences.push(Math.abs(bright(bytes, mine) - bright(theirs, 4 * at)));
  }
  differences.sort((a, b) => a - b);
  told.median = differences[differences.length >> 1];
  return told;
}
