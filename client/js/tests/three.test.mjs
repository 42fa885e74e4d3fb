// ForelandTerrain in headless Chromium, in the examples' own scenes: what three's lights, shadows, fog, clipping and depth make of it, what
// it leaves of the graphics interface's state, and what it gives back. Every wait is for a condition.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { complainOfWarnings, is_soak, makeFolder, makeScene, makeSceneWithObjects, openBrowser, openPage, package_folder, startServer } from './support.mjs';
import { serveFolder } from './static_server.mjs';

const kTest = { timeout: 600_000 };
let folder, scene, server, crowded, files, browser;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeScene(folder.folder, { size: 257 }));
  crowded = await startServer(await makeSceneWithObjects(folder.folder, 3));
  files = await serveFolder(package_folder);
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  for (const one of [server, crowded, files]) await one?.stop();
  await folder?.remove();
});

// Runs `body` with an example over a served scene, small because a processor draws it, with its own loop stopped; nothing may have gone
// wrong in it.
async function visit(name, body, { at = server, expected } = {}) {
  const { page, complaints, close } = await openPage(browser, { width: 192, height: 108 });
  page.setDefaultTimeout(120_000);
  complainOfWarnings(page, complaints);
  try {
    await page.goto(new URL(`examples/${name}.html?server=${encodeURIComponent(at.url.href)}`, files.url).href);
    while (!(await page.evaluate(() => globalThis.ground?.drawn.version > 0))) await page.waitForTimeout(50);
    await page.evaluate(helpers);
    await body(page);
    assert.deepEqual(complaints.filter((complaint) => !expected?.test(complaint)), []);
  } finally {
    await close();
  }
}

// What the tests do in the page.
function helpers() {
  renderer.setAnimationLoop(null);
  const gl = renderer.getContext();
  globalThis.draw = () => {
    const frame = ground.update(camera, performance.now());
    renderer.render(scene, camera);
    return frame;
  };
  globalThis.pixels = () => {
    draw();
    const { width, height } = renderer.domElement;
    const bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  };
  // The share of pixels that differ by more than `most` in a channel.
  globalThis.differing = (a, b, most = 8) => {
    let count = 0;
    for (let i = 0; i < a.length; i += 4) if ([0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > most)) ++count;
    return (4 * count) / a.length;
  };
  // Until nothing new comes: the same mesh and tiles over several keyframes.
  globalThis.settle = async () => {
    for (let since = 0, last = ''; ;) {
      const frame = draw();
      const { keyframes, tiles_received } = terrain.stats;
      const now = JSON.stringify([ground.drawn.reliefTiles, ground.drawn.triangles, frame.guaranteedPx, tiles_received]);
      if (now !== last) since = keyframes;
      last = now;
      if (frame.guaranteedPx !== null && ground.drawn.reliefTiles > 0 && keyframes > since + 10) return;
      await new Promise((done) => setTimeout(done, 30));
    }
  };
}

test('a scene of its user flies: guaranteed, in order, and leaving no state behind', kTest, () =>
  visit('three-basic', async (page) => {
    const told = await page.evaluate(async () => {
      const gl = renderer.getContext();
      const kNames = ['ARRAY_BUFFER_BINDING', 'COPY_READ_BUFFER_BINDING', 'COPY_WRITE_BUFFER_BINDING', 'PIXEL_UNPACK_BUFFER_BINDING', 'UNIFORM_BUFFER_BINDING',
        'VERTEX_ARRAY_BINDING', 'ACTIVE_TEXTURE', 'READ_FRAMEBUFFER_BINDING', 'DRAW_FRAMEBUFFER_BINDING', 'RENDERBUFFER_BINDING', 'CURRENT_PROGRAM', 'UNPACK_ALIGNMENT',
        'UNPACK_ROW_LENGTH', 'UNPACK_SKIP_ROWS', 'UNPACK_SKIP_PIXELS', 'UNPACK_FLIP_Y_WEBGL', 'UNPACK_PREMULTIPLY_ALPHA_WEBGL', 'UNPACK_COLORSPACE_CONVERSION_WEBGL',
        'UNPACK_IMAGE_HEIGHT', 'UNPACK_SKIP_IMAGES', 'BLEND', 'CULL_FACE', 'DEPTH_TEST', 'SCISSOR_TEST', 'STENCIL_TEST', 'DEPTH_FUNC', 'DEPTH_WRITEMASK',
        'ELEMENT_ARRAY_BUFFER_BINDING', 'TEXTURE_BINDING_2D', 'TEXTURE_BINDING_2D_ARRAY', 'TEXTURE_BINDING_3D', 'TEXTURE_BINDING_CUBE_MAP'];
      const state = () => kNames.map((name) => gl.getParameter(gl[name]));
      const told = { changed: new Set(), beyond: 0, guaranteed: 0, late: 0, versions: new Set(), error: 0, uploads: 0, scissored: 0 };
      // Evenly, however frames come: where a server cannot foresee a camera it states a larger tolerance.
      const begun = performance.now(), start = camera.position.x, kSpeed = 0.8; // metres a millisecond
      // Flies until meshes have come and gone, and rests until what is drawn is guaranteed.
      for (let i = 0; told.versions.size < 5 || told.guaranteed < 5; ++i) {
        const now = performance.now();
        if (told.versions.size < 5) camera.position.x = start + kSpeed * (now - begun);
        // As another library may have left it.
        if (i % 3 === 1) gl.enable(gl.SCISSOR_TEST), gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true), gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 7);
        const before = state();
        const frame = ground.update(camera, now);
        state().forEach((value, k) => value !== before[k] && told.changed.add(kNames[k]));
        if (i % 3 === 1) gl.disable(gl.SCISSOR_TEST), gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false), gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
        renderer.render(scene, camera);
        told.versions.add(frame.version);
        if (frame.guaranteedPx !== null) ++told.guaranteed;
        if (frame.guaranteedPx > 1) ++told.beyond;
        if (ground.drawn.uploadedBytes > 0) ++told.uploads;
        told.error ||= gl.getError();
        await new Promise((done) => setTimeout(done, 10));
      }
      // After a jump, where a frame may upload next to nothing.
      const { card } = ground, add = card.add.bind(card), { onMesh } = ground, jump = { came: null, drawn: null };
      let frames = 0;
      ground.options.bytesPerFrame = 1;
      card.add = (update) => (update.terrain.is_whole && update.oldest_version === update.version && (jump.came ??= frames), add(update));
      ground.onMesh = () => jump.came !== null && (jump.drawn ??= frames);
      terrain.jump();
      for (camera.position.x += 500; jump.drawn === null; ++frames) {
        ground.update(camera, performance.now());
        await new Promise((done) => setTimeout(done, 10));
      }
      ground.onMesh = onMesh;
      delete card.add;
      delete ground.options.bytesPerFrame;
      told.wait_after_jump = jump.drawn - jump.came;
      return { ...told, changed: [...told.changed], versions: [...told.versions] };
    });
    assert.deepEqual(told.changed, []);
    assert.equal(told.beyond, 0);
    assert.equal(told.error, 0);
    assert.ok(told.uploads > 1);
    assert.ok(told.wait_after_jump <= 1, `drawn ${told.wait_after_jump} frames after it had come`);
    assert.deepEqual(told.versions, [...told.versions].sort((a, b) => a - b));
  }));

test('things hide the ground and are hidden by it; fog, clipping and the style take effect', kTest, () =>
  visit('three-basic', async (page) => {
    const told = await page.evaluate(async () => {
      await settle();
      const { low, high } = terrain.scene.bounds;
      const plain = pixels();
      const share = {};
      share.again = differing(plain, pixels());
      const eye = camera.position.toArray();
      const towards = controls_target().sub(camera.position);
      const met = terrain.raycast(eye, towards.toArray());
      const cube = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), new THREE.MeshBasicMaterial({ color: 0xff00ff }));
      scene.add(cube);
      const ray = new THREE.Vector3(...met).sub(camera.position);
      const side = 0.1 * ray.length();
      cube.scale.setScalar(side);
      cube.position.copy(camera.position).addScaledVector(ray, 0.6);
      share.hides = differing(plain, pixels());
      cube.position.copy(camera.position).addScaledVector(ray, 1.0);
      cube.position.z -= 2 * side;
      share.hidden = differing(plain, pixels());
      scene.remove(cube);
      scene.fog = new THREE.Fog(0xff0000, 1, 2);
      ground.groundMaterial.needsUpdate = true;
      const fogged = pixels();
      let red = 0, sky = 0;
      for (let i = 0; i < fogged.length; i += 4) {
        if (fogged[i] > 250 && fogged[i + 1] < 5) ++red;
        else ++sky;
      }
      share.red = red / (red + sky);
      scene.fog = null;
      ground.groundMaterial.needsUpdate = true;
      renderer.clippingPlanes = [new THREE.Plane(new THREE.Vector3(0, 0, 1), -high[2] - 1)]; // nothing is above
      const empty = pixels();
      share.clipped = differing(empty, plain);
      renderer.clippingPlanes = [];
      const restored = pixels();
      share.restored = differing(plain, restored);
      ground.setStyle({ ground: 'slope', contours: true });
      share.styled = differing(plain, pixels());
      ground.setStyle({ ground: 'natural', contours: false });
      scene.traverse((object) => object.isLight && (object.intensity *= 0.3));
      share.darker = differing(plain, pixels());
      function controls_target() { return new THREE.Vector3(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]); }
      const caster = new THREE.Raycaster(camera.position.clone(), ray.clone().normalize());
      share.met = caster.intersectObject(ground)[0].point.distanceTo(new THREE.Vector3(...met)) / ray.length();
      return share;
    });
    assert.ok(told.again < 0.002, `${told.again} of a picture at rest changes`);
    assert.ok(told.hides > 0.01 && told.hides < 0.3, `a cube before the ground covers ${told.hides}`);
    assert.ok(told.hidden < 0.003, `a cube below the ground shows in ${told.hidden}`);
    assert.ok(told.red > 0.3, `fog covers ${told.red}`);
    assert.ok(told.clipped > 0.3, `clipping takes ${told.clipped}`);
    assert.ok(told.restored < 0.003, `and gives back all but ${told.restored}`);
    assert.ok(told.styled > 0.2 && told.darker > 0.2, JSON.stringify(told));
    assert.ok(told.met < 1e-3, `a ray meets the ground ${told.met} of its way off`);
  }));

test('shadows fall on the ground and from it, and a frame can go through other passes', kTest, () =>
  visit('three-shadows-and-models', async (page) => {
    const told = await page.evaluate(async () => {
      draw();
      await settle();
      const share = {};
      const all = pixels();
      tower.castShadow = false;
      share.of_tower = differing(all, pixels());
      tower.castShadow = true;
      const own = [];
      ground.traverse((object) => object.isMesh && object.castShadow && own.push(object));
      for (const mesh of own) mesh.castShadow = false;
      share.of_ground = differing(all, pixels());
      for (const mesh of own) mesh.castShadow = true;
      share.back = differing(all, pixels());
      const target = new THREE.WebGLRenderTarget(64, 36, { type: THREE.HalfFloatType, samples: 4 });
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      renderer.setRenderTarget(null);
      const lit = new Uint16Array(4 * 64 * 36);
      renderer.readRenderTargetPixels(target, 0, 0, 64, 36, lit);
      share.lit = new Set(lit).size;
      target.dispose();
      return share;
    });
    assert.ok(told.of_tower > 0.0005 && told.of_tower < 0.3, `the tower's shadow has ${told.of_tower} of the picture`);
    assert.ok(told.of_ground > 0.0005, `the ground's has ${told.of_ground}`);
    assert.ok(told.back < 0.003);
    assert.ok(told.lit > 200, 'another target has a picture');
  }));

test('after the graphics card was reset the ground comes back', kTest, () =>
  visit('three-basic', async (page) => {
    const share = await page.evaluate(async () => {
      const [before, { triangles }] = [pixels(), ground.drawn];
      const loser = renderer.getContext().getExtension('WEBGL_lose_context');
      const lost = new Promise((done) => renderer.domElement.addEventListener('webglcontextlost', done, { once: true }));
      loser.loseContext();
      await lost;
      for (let i = 0; i < 3; ++i) ground.update(camera, performance.now());
      const restored = new Promise((done) => renderer.domElement.addEventListener('webglcontextrestored', done, { once: true }));
      await new Promise((done) => setTimeout(done, 0));
      loser.restoreContext();
      await restored;
      while (ground.drawn.triangles < 0.9 * triangles) {
        draw();
        await new Promise((done) => setTimeout(done, 20));
      }
      // Tiles of relief may still come, by which slopes are shaded anew.
      return { differing: differing(before, pixels(), 64), connected: terrain.isConnected };
    });
    assert.ok(share.differing < 0.05, `${share.differing} of the picture is another one`);
    assert.ok(share.connected);
  }, { expected: /Context Lost|Context Restored/ }));

test('many terrains in a row leave no object of the graphics interface', kTest, () =>
  visit('three-basic', async (page) => {
    const held = await page.evaluate(async (many) => {
      const gl = renderer.getContext();
      const alive = {};
      for (const kind of ['Buffer', 'Texture', 'Framebuffer', 'VertexArray', 'Program', 'Shader']) {
        const live = new Set();
        const [create, remove] = [gl[`create${kind}`], gl[`delete${kind}`]];
        gl[`create${kind}`] = function (...all) { const made = create.apply(this, all); live.add(made); return made; };
        gl[`delete${kind}`] = function (gone) { live.delete(gone); return remove.call(this, gone); };
        alive[kind] = live;
      }
      const { Terrain } = await import('@foreland/client');
      const { ForelandTerrain } = await import('@foreland/client/three');
      const counts = [];
      ground.dispose();
      for (let i = 0; i < many; ++i) {
        const is_new = i % 10 === 0; // a session of its own
        const other = is_new ? await Terrain.open(new URLSearchParams(location.search).get('server')) : terrain;
        const one = new ForelandTerrain(other, { renderer });
        scene.add(one);
        while (one.drawn.version === 0) {
          one.update(camera, performance.now());
          await new Promise((done) => setTimeout(done, 5));
        }
        renderer.render(scene, camera);
        one.dispose();
        if (is_new) await other.close();
        counts.push(Object.values(alive).reduce((sum, live) => sum + live.size, 0));
      }
      return { counts, geometries: renderer.info.memory.geometries, textures: renderer.info.memory.textures };
    }, is_soak ? 50 : 15);
    assert.ok(held.counts.at(-1) <= held.counts[1] + 2, held.counts.join(' '));
  }));

test('objects of a scene have the scene\'s light, and their images', kTest, () =>
  visit('three-basic', async (page) => {
    const told = await page.evaluate(async () => {
      const { low, high } = terrain.scene.bounds;
      camera.position.set(0.5 * (low[0] + high[0]), low[1] - 0.2 * (high[1] - low[1]), high[2] + 300);
      camera.lookAt(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]);
      while (!(ground.drawn.objectTriangles > 0 && ground.drawn.objectImages > 0)) {
        draw();
        await new Promise((done) => setTimeout(done, 20));
      }
      await settle();
      const with_objects = pixels();
      ground.traverse((object) => object.isMesh && Array.isArray(object.material) && (object.visible = false));
      const share = differing(with_objects, pixels());
      // What rays meet first, beside what the server says of the same lines of sight.
      const rays = [], caster = new THREE.Raycaster();
      for (let x = -0.96; x < 1; x += 0.04) {
        for (let y = -0.9; y < 0.9; y += 0.04) {
          caster.setFromCamera(new THREE.Vector2(x, y), camera);
          const [met] = caster.intersectObject(ground);
          if (met?.instanceId !== undefined) rays.push({ met, ray: caster.ray.clone() });
        }
      }
      const eye = terrain.toGeodetic(camera.position.toArray());
      const answers = await terrain.visible(rays.map(({ met, ray }) => [eye, terrain.toGeodetic(ray.at(1.5 * met.distance, new THREE.Vector3()).toArray())]), { refraction: 1 });
      const same = answers.filter(({ object, hit }, i) => object === rays[i].met.instanceId && rays[i].met.point.distanceTo(new THREE.Vector3(...hit)) < 0.005 * rays[i].met.distance);
      return { share, rays: rays.length, same: same.length, objects: new Set(rays.map(({ met }) => met.instanceId)).size };
    });
    assert.ok(told.rays > 5 && told.objects > 1, JSON.stringify(told));
    assert.ok(told.same >= 0.9 * told.rays, JSON.stringify(told)); // edges may differ by what the guarantee allows
    assert.ok(told.share > 0.0005 && told.share < 0.2, `objects have ${told.share} of the picture`);
  }, { at: crowded }));
