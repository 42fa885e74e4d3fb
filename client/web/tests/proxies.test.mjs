// The page in headless Chromium behind nginx, in frames without a size, and where its server's address will not do. Every wait is for a
// condition.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { promisify } from 'node:util';
import { freePort, makeFolder, makeScene, openBrowser, openPage, root, startNginx, startServer, until, untilTerrain } from './support.mjs';

const kTest = { timeout: 180_000 };
let folder, scene, server, nginx, browser, at;

// Under a path with the configuration that is shipped; at the root as nginx passes nothing on unless it is told to.
before(async () => {
  folder = await makeFolder();
  scene = await makeScene(folder.folder, { size: 129 });
  server = await startServer(scene);
  at = { path: await freePort(), stripped: await freePort() };
  const shipped = await readFile(join(root, 'deploy/nginx.conf'), 'utf8');
  const plain = `server { listen 127.0.0.1:${at.stripped}; location / { proxy_pass http://127.0.0.1:${server.port}; } }`;
  nginx = await startNginx(folder.folder, shipped.replace('listen 127.0.0.1:8080', `listen 127.0.0.1:${at.path}`)
    .replace('http://127.0.0.1:8081', `http://127.0.0.1:${server.port}`) + plain, [at.path, at.stripped]);
  browser = await openBrowser();
}, kTest);

after(async () => {
  await browser?.close();
  await nginx?.stop();
  await server?.stop();
  await folder?.remove();
});

// Runs `body` with a page at an address; it may complain of what `expected` says.
async function visit(url, body, expected) {
  const { page, complaints, close } = await openPage(browser);
  try {
    const sockets = [];
    page.on('websocket', (socket) => sockets.push(socket.url()));
    await page.goto(url);
    await body(page, sockets);
    assert.deepEqual(complaints.filter((c) => !expected?.test(c)), []);
  } finally {
    await close();
  }
}

test('a page under a path connects beside it', kTest, () =>
  visit(`http://127.0.0.1:${at.path}/terrain/?sharpness=0.6&tau=4`, async (page) => {
    await untilTerrain(page);
    assert.equal(await page.locator('#notice').isVisible(), false);
  }));

test('behind a proxy that passes no Upgrade on the page says what it lacks, and what the server says', kTest, () =>
  visit(`http://127.0.0.1:${at.stripped}/`, async (page) => {
    await page.getByText(/a proxy on the way does not pass Upgrade on\. nginx needs proxy_http_version 1\.1/).waitFor();
    await page.getByText(/The server said: This address speaks WebSocket/).waitFor();
  }, /WebSocket|426/));

test('why a server lets nobody in is said, of whatever origin it is', kTest, async () => {
  const closed = await startServer(scene, 0, await secret());
  try {
    await visit(closed.url.href, (page) => page.getByText(/The server said: A token is needed: .*#token=/).waitFor(), /WebSocket|401/);
    await visit(new URL(`?server=${new URL('fly', closed.url).href}`, server.url).href,
      (page) => page.getByText(/The server said: A token is needed/).waitFor(), /WebSocket|401/);
  } finally {
    await closed.stop();
  }
});

test('a server that is named without a scheme is told of, with one that will do', kTest, () =>
  visit(new URL(`?sharpness=0.6&tau=4&server=127.0.0.1:${server.port}`, server.url).href, async (page) => {
    await page.getByText('There is no such server.').waitFor();
    await page.getByRole('button', { name: `Connect to ws://127.0.0.1:${server.port}/fly` }).click();
    await untilTerrain(page);
  }));

test('a page that came by https says that it cannot connect without TLS', kTest, async () => {
  const secure = await startServer(scene, 0, await certificate());
  try {
    await visit(new URL('?server=ws://terrain.example:8080/fly', secure.url).href, async (page, sockets) => {
      await page.getByText('The browser does not connect to this server.').waitFor();
      await page.getByText(/came by https.*--tls-cert/).waitFor();
      await page.getByRole('button', { name: 'Connect to wss://terrain.example:8080/fly' }).waitFor();
      assert.deepEqual(sockets, []);
    });
    await visit(new URL('?sharpness=0.6&tau=4', secure.url).href, untilTerrain);
  } finally {
    await secure.stop();
  }
});

for (const [how, hidden, shown] of [
  ['is hidden', 'display: none; width: 640px; height: 360px', 'width: 640px; height: 360px'],
  ['has no width', 'width: 0; height: 360px; border: 0', 'width: 640px; height: 360px; border: 0'],
  ['has less than a pixel', 'width: 1px; height: 1px; border: 0', 'width: 640px; height: 360px; border: 0'],
]) {
  test(`in a frame that ${how} the page waits, and goes on when it has a size`, kTest, async () => {
    const { page, complaints, close } = await openPage(browser);
    try {
      const sockets = [];
      page.on('websocket', (socket) => sockets.push(socket.url()));
      await page.route('**/frame.html', (route) => route.fulfill({ contentType: 'text/html', headers: { 'Cross-Origin-Embedder-Policy': 'require-corp' },
        body: `<body><iframe style="${hidden}" src="/?sharpness=0.6&tau=4"></iframe>` }));
      await page.goto(new URL('frame.html', server.url).href);
      const frame = page.frame({ url: /sharpness/ });
      const style = (text) => page.locator('iframe').evaluate((element, css) => (element.style.cssText = css), text);
      await until(frame, () => true); // it has started
      assert.deepEqual(sockets, [], 'it waits');
      await style(shown);
      const { keyframes } = await untilTerrain(frame);
      assert.equal(sockets.length, 1);
      await style(hidden);
      if (!hidden.includes('none')) await until(frame, () => window.innerWidth < 2); // Chromium leaves what is hidden its size
      const [width, height] = await frame.locator('#scene').evaluate((canvas) => [canvas.width, canvas.height]);
      assert.ok(width > 1 && height > 1, `the lens is ${width} x ${height}`);
      await style(shown);
      await until(frame, (s, n) => s.connected && s.keyframes > n + 5, keyframes);
      assert.equal(await frame.locator('#notice').isVisible(), false);
      assert.equal(sockets.length, 1, 'the session has gone on');
      assert.deepEqual(complaints, []);
    } finally {
      await close();
    }
  });
}

async function secret() {
  const file = join(folder.folder, 'secret');
  await promisify(execFile)('sh', ['-c', `openssl rand -base64 48 > ${file}`]);
  return ['--token-secret', file];
}
async function certificate() {
  const [key, cert] = ['key.pem', 'cert.pem'].map((name) => join(folder.folder, name));
  await promisify(execFile)('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1', '-nodes', '-days', '2',
    '-subj', '/CN=localhost', '-addext', 'subjectAltName=IP:127.0.0.1', '-keyout', key, '-out', cert]);
  return ['--tls-cert', cert, '--tls-key', key];
}
