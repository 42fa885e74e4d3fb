// Flies the fixtures and the examples once in Firefox, by WebDriver BiDi, and prints what came of each and what the console said.
// By hand, not by ./check, which has Chromium alone: `apt-get install firefox-esr libegl1 libgl1-mesa-dri xvfb`,
// npm run build, then, as Firefox without a display has no WebGL where there is no graphics card,
//
//   xvfb-run -a node client/js/tests/firefox.mjs
import { spawn } from 'node:child_process';
import { cp, mkdir, symlink, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import WebSocket from 'ws';
import { makeFolder, makeScene, makeSceneOnEarth, package_folder, startServer } from './support.mjs';
import { pack, projects } from './projects.mjs';
import { serveFolder } from './static_server.mjs';

const kPatience_ms = 60_000;

// A session of BiDi: `ask` sends a command, `logs` has what consoles said.
async function openFirefox(profile) {
  const child = spawn(process.env.FIREFOX ?? 'firefox-esr', [...(process.env.DISPLAY ? [] : ['--headless']), '--no-remote', '--remote-debugging-port', '0', '--profile', profile], { stdio: ['ignore', 'ignore', 'pipe'] });
  const ended = new Promise((done) => child.once('exit', done));
  const at = await new Promise((found, fail) => {
    child.once('error', fail);
    ended.then((code) => fail(new Error(`Firefox ended: ${code}`)));
    createInterface({ input: child.stderr }).on('line', (line) => line.match(/ws:\/\/\S+/) && found(line.match(/ws:\/\/\S+/)[0]));
  });
  const socket = new WebSocket(`${at}/session`), waiting = new Map(), logs = [];
  await new Promise((done, fail) => socket.once('open', done).once('error', fail));
  socket.on('message', (text) => {
    const message = JSON.parse(text);
    if (message.method === 'log.entryAdded') logs.push(`${message.params.level}: ${message.params.text}`);
    const one = waiting.get(message.id);
    if (one) message.type === 'error' ? one.fail(new Error(message.message)) : one.done(message.result);
  });
  let next = 0;
  const ask = (method, params) => new Promise((done, fail) => {
    waiting.set(++next, { done, fail });
    socket.send(JSON.stringify({ id: next, method, params }));
  });
  const { capabilities } = await ask('session.new', { capabilities: {} });
  await ask('session.subscribe', { events: ['log.entryAdded'] });
  const close = async () => {
    socket.close();
    child.kill();
    await ended;
  };
  return { ask, logs, close, version: capabilities.browserVersion };
}

// What `expression` becomes in a page, once it is something.
async function visit({ ask, logs }, url, expression) {
  logs.length = 0;
  const { context } = await ask('browsingContext.create', { type: 'tab' });
  try {
    await ask('browsingContext.navigate', { context, url, wait: 'complete' });
    const until = Date.now() + kPatience_ms;
    for (;;) {
      const { result, exceptionDetails } = await ask('script.evaluate', { expression: `JSON.stringify(${expression} ?? null)`, target: { context }, awaitPromise: true });
      if (exceptionDetails) return { failed: exceptionDetails.text };
      if (result.value !== 'null') return JSON.parse(result.value);
      if (Date.now() > until) return { failed: `nothing in ${kPatience_ms / 1000} s` };
      await new Promise((done) => setTimeout(done, 100));
    }
  } finally {
    await ask('browsingContext.close', { context });
  }
}

const folder = await makeFolder();
const [scene, on_earth] = [await startServer(await makeScene(folder.folder, { size: 257 })), await startServer(await makeSceneOnEarth(folder.folder))];
const files = await serveFolder(folder.folder);
await mkdir(join(folder.folder, 'package/profile'), { recursive: true });
for (const name of ['dist', 'examples']) await cp(join(package_folder, name), join(folder.folder, 'package', name), { recursive: true });
await symlink(join(package_folder, 'node_modules'), join(folder.folder, 'package/node_modules'));
// A machine without a graphics card: Mesa draws, which Firefox does not use by itself.
await writeFile(join(folder.folder, 'package/profile/user.js'), 'user_pref("webgl.force-enabled", true);\n');
const firefox = await openFirefox(join(folder.folder, 'package/profile'));
console.log(`Firefox ${firefox.version}`);
const tell = async (name, path, server, expression) => {
  const told = await visit(firefox, new URL(`${path}?server=${encodeURIComponent(server.url.href)}`, files.url).href, expression);
  console.log(`${name}: ${JSON.stringify(told)}`);
  for (const line of new Set(firefox.logs)) console.log(`  ${line}`);
};
try {
  const packed = await pack(folder.folder);
  for (const [name, make] of Object.entries(projects)) await tell(name, await make({ folder: folder.folder, packed }), scene, 'globalThis.flown');
  const drawn = '(globalThis.ground?.drawn.version > 3 && terrain.lastFrame.guaranteedPx !== null ? { ...ground.drawn, px: terrain.lastFrame.guaranteedPx } : null)';
  for (const name of ['three-basic', 'three-shadows-and-models']) await tell(name, `package/examples/${name}.html`, scene, drawn);
  await tell('maplibre', 'package/examples/maplibre.html', on_earth, '(globalThis.layer?.ground?.drawn.version > 3 ? { ...layer.ground.drawn, px: layer.frame.guaranteedPx } : null)');
} finally {
  await firefox.close();
  for (const one of [scene, on_earth, files]) await one.stop();
  await folder.remove();
}
