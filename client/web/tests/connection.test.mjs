// The page's connection over sockets that a test holds: what is sent, in which order, and when it connects anew.
import assert from 'node:assert/strict';
import { after, before, beforeEach, test } from 'node:test';
import { openSources } from './support.mjs';

let sources, Connection;
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
  ({ Connection } = await sources.load('core/connection.ts'));
  globalThis.WebSocket = HeldSocket;
});
after(async () => {
  Object.assign(globalThis, real);
  await sources?.close();
});
beforeEach(() => (sockets.splice(0), timers.splice(0)));

// Opens a connection, and tells what it tells.
function connect(url = 'ws://127.0.0.1/fly') {
  const told = { opened: 0, waits: [], impossible: [] };
  const connection = new Connection(url, {
    onOpen: () => ++told.opened, onMessage: () => {}, onWaiting: (_, reason) => told.waits.push(reason), onImpossible: (reason) => told.impossible.push(reason),
  });
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
