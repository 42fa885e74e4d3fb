// A WebSocket client and a server for tests under Node 18, which has none: binary messages whole, pings answered. Messages of the server are
// never fragmented beyond what is joined here.
import { createHash, randomBytes } from 'node:crypto';
import { createServer, request } from 'node:http';

const kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;

// Resolves when the server has accepted; `onMessage` gets each message as bytes.
export async function openSocket(url, onMessage) {
  const headers = { Connection: 'Upgrade', Upgrade: 'websocket', 'Sec-WebSocket-Version': '13' };
  headers['Sec-WebSocket-Key'] = randomBytes(16).toString('base64');
  const asked = request(url, { headers });
  const { stream, head } = await new Promise((done, fail) => {
    asked.on('upgrade', (_answer, stream, head) => done({ stream, head }));
    asked.on('response', (answer) => fail(new Error(`HTTP ${answer.statusCode} instead of a WebSocket`)));
    asked.on('error', fail);
    asked.end();
  });
  const closed = new Promise((done) => stream.once('close', done));
  stream.on('error', () => stream.destroy());
  const send = (payload, opcode = kBinary) => stream.write(Buffer.concat([frameHead(opcode, payload.length), payload]));
  readFrames(stream, head, (opcode, payload) => {
    if (opcode === kBinary || opcode === kText) onMessage(new Uint8Array(payload));
    if (opcode === kPing) send(payload, kPong);
    if (opcode === kClose) stream.end();
  });
  const close = () => (send(Buffer.from([0x03, 0xe8]), kClose), closed);
  return { send, close, closed };
}

// A server that says one short message to whoever connects.
export async function serveMessage(message) {
  const server = createServer();
  server.on('upgrade', ({ headers }, stream) => {
    const accept = createHash('sha1').update(`${headers['sec-websocket-key']}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest('base64');
    stream.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`);
    stream.write(Buffer.concat([Buffer.from([0x80 | kBinary, message.length]), message]));
    stream.on('error', () => stream.destroy());
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const close = () => (server.close(), server.closeAllConnections());
  return { url: `ws://127.0.0.1:${server.address().port}/fly`, close };
}

// A final frame; its mask is zero, so the payload follows as it is.
function frameHead(opcode, size) {
  const short = size < 126 ? size : size < 65536 ? 126 : 127;
  const head = Buffer.alloc(2 + (short === 126 ? 2 : short === 127 ? 8 : 0) + 4);
  head[0] = 0x80 | opcode;
  head[1] = 0x80 | short;
  if (short === 126) head.writeUInt16BE(size, 2);
  if (short === 127) head.writeBigUInt64BE(BigInt(size), 2);
  return head;
}

// Calls `onFrame` with each whole message or control frame.
function readFrames(stream, first, onFrame) {
  let held = first, parts = [], opcode_of_parts = 0;
  const take = () => {
    if (held.length < 2) return false;
    const short = held[1] & 127;
    const begin = 2 + (short === 126 ? 2 : short === 127 ? 8 : 0);
    if (held.length < begin) return false;
    const size = short < 126 ? short : short === 126 ? held.readUInt16BE(2) : Number(held.readBigUInt64BE(2));
    if (held.length < begin + size) return false;
    const opcode = held[0] & 15, is_last = (held[0] & 128) !== 0, payload = held.subarray(begin, begin + size);
    held = held.subarray(begin + size);
    if (opcode >= kClose) return onFrame(opcode, payload), true;
    if (opcode !== 0) (parts = []), (opcode_of_parts = opcode);
    parts.push(payload);
    if (is_last) onFrame(opcode_of_parts, Buffer.concat(parts));
    return true;
  };
  const takeAll = () => { while (take()); };
  stream.on('data', (more) => ((held = Buffer.concat([held, more])), takeAll()));
  takeAll();
}
