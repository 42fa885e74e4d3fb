// ForelandTerrain with what a user's scene may have beside the usual: reversed depth, the earth's own frame, and a server that lies under a
// path behind nginx, as deploy/nginx.conf has it.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { complainOfWarnings, freePort, makeFolder, makeSceneOnEarth, makeSceneWithObjects, openBrowser, openPage, package_folder, root, startNginx, startServer } from './support.mjs';
import { serveFolder } from './static_server.mjs';

const kTest = { timeout: 600_000 };
let folder, earth, crowded, nginx, proxied, files, browser;

before(async () => {
  folder = await makeFolder();
  earth = await startServer(await makeSceneOnEarth(folder.folder));
  crowded = await startServer(await makeSceneWithObjects(folder.folder, 3));
  const port = await freePort(), shipped = await readFile(join(root, 'deploy/nginx.conf'), 'utf8');
  const config = shipped.replace('listen 127.0.0.1:8080', `listen 127.0.0.1:${port}`).replace('proxy_pass http://127.0.0.1:8081/', `proxy_pass http://127.0.0.1:${crowded.port}/`);
  nginx = await startNginx(folder.folder, config, [port]);
  proxied = new URL(`http://127.0.0.1:${port}/terrain/`);
  files = await serveFolder(package_folder);
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  for (const one of [earth, crowded, nginx, files]) await one?.stop();
  await folder?.remove();
});

// Runs `work` in the example over a scene; nothing may have gone wrong in it.
async function visit(server, work) {
  const { page, complaints, close } = await openPage(browser, { width: 192, height: 108 });
  page.setDefaultTimeout(120_000);
  complainOfWarnings(page, complaints);
  try {
    await page.goto(new URL(`examples/three-basic.html?server=${encodeURIComponent(server.href)}`, files.url).href);
    await page.waitForFunction(() => globalThis.ground?.drawn.version > 0, null, { polling: 50 });
    await page.evaluate(helpers);
    const told = await page.evaluate(work);
    assert.deepEqual(complaints, []);
    return told;
  } finally {
    await close();
  }
}

// What the tests do in the page: pictures of a ground by a renderer, at rest.
function helpers() {
  renderer.setAnimationLoop(null);
  globalThis.drawn = (by, ground) => {
    ground.update(camera, performance.now());
    by.render(scene, camera);
    const gl = by.getContext(), { width, height } = by.domElement, bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  };
  globalThis.settled = async (by, ground) => {
    for (let since = 0, last = ''; ;) {
      drawn(by, ground);
      const now = JSON.stringify([ground.drawn.reliefTiles, ground.drawn.imageryTiles, ground.drawn.triangles, terrain.lastFrame.guaranteedPx]);
      if (now !== last) since = terrain.stats.keyframes;
      last = now;
      if (terrain.lastFrame.guaranteedPx !== null && ground.drawn.reliefTiles > 0 && terrain.stats.keyframes > since + 8) return drawn(by, ground);
      await new Promise((done) => setTimeout(done, 20));
    }
  };
  globalThis.differing = (a, b, most = 8) => {
    let count = 0;
    for (let i = 0; i < a.length; i += 4) if ([0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > most)) ++count;
    return (4 * count) / a.length;
  };
}

test('reversed depth draws the same, and things hide ground and are hidden by it', kTest, async () => {
  const told = await visit(earth.url, async () => {
    const { ForelandTerrain } = await import('@foreland/client/three');
    const plain = await settled(renderer, ground);
    const eye = camera.position.clone(), towards = new THREE.Vector3(0, 0, -1).applyQuaternion(camera.quaternion);
    const ray = towards.multiplyScalar(terrain.pick(eye.toArray(), towards.toArray()).distance);
    const cube = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), new THREE.MeshBasicMaterial({ color: 0xff00ff }));
    cube.scale.setScalar(0.1 * ray.length());
    const withCube = (by, ground, share) => {
      cube.position.copy(eye).addScaledVector(ray, share);
      cube.position.z -= share === 1 ? 2 * cube.scale.x : 0;
      scene.add(cube);
      const bytes = drawn(by, ground);
      scene.remove(cube);
      return bytes;
    };
    ground.dispose();
    const reversed = new THREE.WebGLRenderer({ antialias: true, reversedDepthBuffer: true });
    reversed.setSize(192, 108);
    const other = new ForelandTerrain(terrain, { renderer: reversed });
    scene.add(other);
    const bytes = await settled(reversed, other);
    return { is_reversed: reversed.capabilities.reversedDepthBuffer, same: differing(plain, bytes), hides: differing(bytes, withCube(reversed, other, 0.6)), hidden: differing(bytes, withCube(reversed, other, 1)) };
  });
  assert.ok(told.is_reversed, 'this Chromium has EXT_clip_control');
  assert.ok(told.same < 0.01, `${told.same} of the picture differs`);
  assert.ok(told.hides > 0.01 && told.hides < 0.3, `a cube before the ground covers ${told.hides}`);
  assert.ok(told.hidden < 0.003, `a cube below the ground shows in ${told.hidden}`);
});

test('in the earth\'s frame the picture is the same, thousands of kilometres from the middle', kTest, async () => {
  const told = await visit(earth.url, async () => {
    const { ForelandTerrain } = await import('@foreland/client/three');
    const plain = await settled(renderer, ground), pose = ground.poseOf(camera);
    ground.dispose();
    const other = new ForelandTerrain(terrain, { renderer, frame: 'ecef' });
    scene.add(other);
    other.poseCamera(camera, pose);
    // The lights keep their directions in the scene.
    const turn = new THREE.Matrix4().extractRotation(other.sceneToWorld);
    scene.traverse((object) => object.isLight && object.position.applyMatrix4(turn));
    const bytes = await settled(renderer, other);
    const place = { lon: 8.1, lat: 46.1, height: 1000 }, at = new THREE.Vector3(...terrain.toScene(place)).applyMatrix4(other.sceneToWorld);
    const [a, e2, lon, lat] = [6378137, 0.00669437999014, (8.1 * Math.PI) / 180, (46.1 * Math.PI) / 180], n = a / Math.sqrt(1 - e2 * Math.sin(lat) ** 2);
    const true_at = [(n + 1000) * Math.cos(lat) * Math.cos(lon), (n + 1000) * Math.cos(lat) * Math.sin(lon), (n * (1 - e2) + 1000) * Math.sin(lat)];
    return { same: differing(plain, bytes), away: camera.position.length(), off: at.distanceTo(new THREE.Vector3(...true_at)) };
  });
  assert.ok(told.away > 6e6);
  assert.ok(told.same < 0.02, `${told.same} of the picture differs`);
  assert.ok(told.off < 1e-3, `a place is ${told.off} m off`);
});

test('a server under a path behind nginx streams ground, objects and their images', kTest, async () => {
  const told = await visit(proxied, async () => {
    const { low, high } = terrain.scene.bounds;
    camera.position.set(0.5 * (low[0] + high[0]), low[1] - 0.2 * (high[1] - low[1]), high[2] + 300);
    camera.lookAt(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]);
    while (!(ground.drawn.objectImages > 0)) drawn(renderer, ground), await new Promise((done) => setTimeout(done, 20));
    return { files: terrain.files.href, server: terrain.server };
  });
  assert.equal(told.files, proxied.href);
  assert.equal(told.server, new URL('fly', proxied).href.replace('http', 'ws'));
});
