// A client's connection over sockets that a test holds: what is sent, in which order, and when it connects anew.
import assert from 'node:assert/strict';
import { after, before, beforeEach, test } from 'node:test';
import { createServer } from 'node:http';
import { openSources } from './support.mjs';

let sources, Connection, askWhy;
const sockets = []; // in the order in which they were opened
const timers = []; // that have not gone off
const real = { WebSocket: globalThis.WebSocket, setTimeout: globalThis.setTimeout, clearTimeout: globalThis.clearTimeout };

// Keeps what it is sent; what is unsent grows while `is_stuck`.
class HeldSocket {
  static OPEN = 1;
  readyState = 0;
  bufferedAmount = 0;
  is_stuck = false;
  sent = [];
  constructor(url) {
    this.url = url;
    if (!url.startsWith('ws')) throw new SyntaxError('the address is wrong');
    sockets.push(this);
  }
  open() {
    this.readyState = 1;
    this.onopen();
  }
  send(message) {
    this.sent.push(message);
    if (this.is_stuck) this.bufferedAmount += message.length;
  }
  drain() {
    [this.is_stuck, this.bufferedAmount] = [false, 0];
  }
  close() {
    this.readyState = 3;
  }
  lose(code = 1006, reason = '') {
    this.readyState = 3;
    this.onclose({ code, reason });
  }
}

before(async () => {
  sources = await openSources();
  ({ Connection } = await sources.load('worker/connection.ts'));
  ({ askWhy } = await sources.load('core/refusal.ts'));
  globalThis.WebSocket = HeldSocket;
});
after(async () => {
  Object.assign(globalThis, real);
  await sources?.close();
});
beforeEach(() => (sockets.splice(0), timers.splice(0)));

// Opens a connection, and tells what it tells. `ask` says why it does not open.
function connect(url = 'ws://127.0.0.1/fly', ask = async () => '', area = () => null) {
  const told = { opened: 0, waits: [], impossible: [] };
  const connection = new Connection(url, {
    onOpen: () => ++told.opened, onMessage: () => {}, onMigrate: () => {}, onWaiting: (_, reason) => told.waits.push(reason), onImpossible: (reason) => told.impossible.push(reason),
  }, area, ask);
  underTimers(() => connection.open());
  return { connection, told };
}
// Timers that `work` sets are kept, not run.
function underTimers(work) {
  Object.assign(globalThis, { setTimeout: (run) => (timers.push(run), run), clearTimeout: (run) => timers.includes(run) && timers.splice(timers.indexOf(run), 1) });
  try {
    return work();
  } finally {
    Object.assign(globalThis, { setTimeout: real.setTimeout, clearTimeout: real.clearTimeout });
  }
}
const runTimers = () => timers.splice(0).forEach((run) => underTimers(run));

test('a connection that takes up nothing more is given up, and made anew', () => {
  const { connection, told } = connect();
  const [first] = sockets;
  first.open();
  first.is_stuck = true;
  for (let i = 0; i < 40_000 && first.readyState === 1; ++i) underTimers(() => connection.send(new Uint8Array(50)));
  assert.equal(first.readyState, 3, 'it is closed');
  assert.ok(first.bufferedAmount > 1 << 20 && first.bufferedAmount < 1.01 * (1 << 20), `at ${first.bufferedAmount} bytes`);
  assert.deepEqual(told.waits, ['The network took up nothing more.']);
  const { length } = first.sent;
  first.drain();
  underTimers(() => connection.send(new Uint8Array(50)));
  assert.equal(first.sent.length, length, 'nothing follows what was left out');
  runTimers();
  assert.equal(sockets.length, 2);
  sockets[1].open();
  assert.equal(told.opened, 2);
  connection.send(Uint8Array.of(7));
  assert.deepEqual(sockets[1].sent.map((m) => [...m]), [[7]]);
});

// For proxies: docs/decisions/0026.
test('each address says the area of its time, once, and none where there is none', () => {
  let area = null;
  const { connection } = connect('ws://127.0.0.1/alps/fly?area=3&a=b&token=t.t-_', undefined, () => area);
  const addressOfNext = () => (underTimers(() => connection.open()), sockets.at(-1).url);
  assert.equal(sockets[0].url, 'ws://127.0.0.1/alps/fly?area=3&a=b&token=t.t-_', 'what a link says stays until more is known');
  for (area of [0, 17, 402653183]) assert.equal(addressOfNext(), `ws://127.0.0.1/alps/fly?area=${area}&a=b&token=t.t-_`);
  connection.setUrl('ws://127.0.0.1/fly');
  assert.equal(addressOfNext(), 'ws://127.0.0.1/fly?area=402653183');
  area = null;
  assert.equal(addressOfNext(), 'ws://127.0.0.1/fly');
  area = 5;
  sockets.at(-1).open();
  underTimers(() => sockets.at(-1).lose(1012));
  assert.equal(sockets.at(-1).url, 'ws://127.0.0.1/fly?area=5', 'a server hands its viewers over');
  underTimers(() => sockets.at(-1).lose());
  area = 6;
  runTimers();
  assert.equal(sockets.at(-1).url, 'ws://127.0.0.1/fly?area=6', 'a connection was lost');
});

// A section to resume from, or a path, is larger than the limit now and then.
test('a large message alone is no reason to give up', () => {
  const { connection, told } = connect();
  const [socket] = sockets;
  socket.open();
  socket.is_stuck = true;
  connection.send(new Uint8Array(5 << 20));
  for (let i = 0; i < 100; ++i) connection.send(new Uint8Array(50));
  assert.equal(socket.sent.length, 101);
  assert.deepEqual(told.waits, []);
});

// Whatever the network does, a server gets all messages of its connection up to some point, and then none.
test('no connection leaves out a message between others', () => {
  const seed = Number(process.env.FORELAND_SEED ?? Math.floor(Math.random() * 1e9));
  console.log(`FORELAND_SEED=${seed}`);
  let state = seed, given_up = 0;
  const random = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32);
  const { connection, told } = connect();
  let expected = []; // of the socket that is open
  for (let step = 0; step < 20_000; ++step) {
    const socket = sockets.at(-1), chance = random();
    if (socket.readyState === 0) socket.open(), (expected = []);
    else if (socket.readyState === 3) runTimers();
    else if (chance < 0.01) socket.is_stuck = true;
    else if (chance < 0.02) socket.drain();
    else if (chance < 0.021) underTimers(() => socket.lose());
    else {
      const message = new Uint8Array(Math.floor(random() ** 8 * 300_000) + 1);
      expected.push(message);
      const waits = told.waits.length;
      underTimers(() => connection.send(message));
      given_up += told.waits.length - waits;
    }
    const { sent } = socket;
    assert.ok(sent.every((m, i) => m === expected[i]), `step ${step} of seed ${seed}`);
    if (socket.readyState === 1) assert.equal(sent.length, expected.length, `step ${step} of seed ${seed}`);
  }
  assert.ok(given_up > 5, `${given_up} connections were given up`);
});

test('what the server says when it closes is passed on, and it is tried again', () => {
  const { told } = connect();
  sockets[0].open();
  underTimers(() => sockets[0].lose(1008, 'no pose for 30 s'));
  assert.deepEqual(told.waits, ['The server said: no pose for 30 s.']);
  runTimers();
  assert.equal(sockets.length, 2);
});

test('an address that the browser does not connect to is told of, and not tried again', () => {
  const { told } = connect('nowhere');
  assert.deepEqual(told.impossible, ['The browser does not connect to nowhere: the address is wrong']);
  assert.deepEqual([told.waits, timers], [[], []]);
});

test('why a connection does not open is asked, said while it waits, and forgotten once it opens', async () => {
  let answer;
  const asked = [];
  const { told } = connect('ws://127.0.0.1/fly', (url) => (asked.push(url), new Promise((done) => (answer = done))));
  underTimers(() => sockets[0].lose());
  assert.deepEqual(told.waits, ['']);
  await underTimers(async () => answer('The server is full.'));
  await new Promise(setImmediate);
  assert.deepEqual(told.waits, ['', 'The server is full.'], 'as soon as it is known');
  runTimers();
  underTimers(() => sockets[1].lose());
  assert.deepEqual(told.waits.slice(2), ['The server is full.'], 'and with the next wait');
  const late = answer;
  runTimers(); // before the answer
  sockets[2].open();
  late('The server is full.');
  await new Promise(setImmediate);
  assert.equal(told.waits.length, 3, 'an answer that comes too late is not said');
  underTimers(() => sockets[2].lose());
  assert.deepEqual(told.waits.slice(3), [''], 'a connection that was open is not asked about');
  assert.deepEqual(asked, ['ws://127.0.0.1/fly', 'ws://127.0.0.1/fly']);
  for (const times of [2, 2, 3]) { // it may come back by itself
    runTimers();
    underTimers(() => sockets.at(-1).lose());
    assert.equal(asked.length, times);
  }
});

// As servers and proxies answer.
test('what answers in place of a WebSocket is said in words', async () => {
  const answers = {
    '/fly': [426, 'text/plain; charset=utf-8', 'This address speaks WebSocket.\n'],
    '/token': [401, 'text/plain', 'A token is needed: ...\n'],
    '/home': [404, 'text/plain', "the company's home page\n"],
    '/html': [502, 'text/html', '<html><h1>Bad Gateway</h1></html>'],
    '/other': [200, 'text/html', '<html>another page</html>'],
    '/long': [503, 'text/plain', 'x '.repeat(5000)],
  };
  const server = createServer(({ url }, reply) => {
    const [status, type, body] = answers[url];
    reply.writeHead(status, { 'Content-Type': type }).end(body);
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address();
  const ask = (path) => askWhy(`ws://127.0.0.1:${port}${path}`);
  assert.match(await ask('/fly'), /a proxy on the way does not pass Upgrade on.*proxy_http_version 1\.1.*The server said: This address speaks WebSocket\.$/);
  assert.equal(await ask('/token'), 'The server said: A token is needed: ...');
  assert.equal(await ask('/home'), "What answers there is no server of terrain (HTTP 404 Not Found). The server said: the company's home page.");
  assert.equal(await ask('/html'), 'The server, or a proxy before it, answers HTTP 502 Bad Gateway.');
  assert.equal(await ask('/other'), 'What answers there is no server of terrain (HTTP 200 OK).');
  assert.ok((await ask('/long')).length < 350);
  server.close();
  server.closeAllConnections();
  assert.equal(await ask('/fly'), '', 'nothing answers');
});
