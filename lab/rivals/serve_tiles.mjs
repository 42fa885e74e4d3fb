// A server of tiles that are cut before the first is asked for, and of the files that pages need. HTTP/1.1 on free loopback ports.
import { createReadStream } from 'node:fs';
import { stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';

const kTypes = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.json': 'application/json', '.wasm': 'application/wasm', '.css': 'text/css' };

async function listen(server) {
  server.keepAliveTimeout = 600_000;
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  return { port: server.address().port, stop: () => new Promise((done) => (server.closeAllConnections(), server.close(done))) };
}

// `tiles`: of each path its body, type and coding.
export const serveTiles = (tiles) =>
  listen(createServer((request, reply) => {
    const tile = tiles.get(decodeURIComponent(new URL(request.url, 'http://x').pathname));
    const shared = { 'access-control-allow-origin': '*', 'access-control-allow-headers': '*', 'cache-control': 'public, max-age=3600' };
    if (request.method === 'OPTIONS') return reply.writeHead(204, { ...shared, 'access-control-max-age': '86400' }).end();
    if (!tile) return reply.writeHead(404, shared).end();
    reply.writeHead(200, { ...shared, 'content-type': tile.type, 'content-length': tile.body.length, ...(tile.coding ? { 'content-encoding': tile.coding } : {}) }).end(tile.body);
  }));

// `folders`: of each first part of a path the folder that it stands for.
export const serveFiles = (folders) =>
  listen(createServer(async (request, reply) => {
    const [, first, ...rest] = normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname)).split('/');
    const path = folders[first] && join(folders[first], ...rest);
    const found = path && (await stat(path).catch(() => null));
    if (!found?.isFile()) return reply.writeHead(first === 'favicon.ico' ? 204 : 404).end();
    reply.writeHead(200, { 'content-type': kTypes[extname(path)] ?? 'application/octet-stream', 'content-length': found.size });
    createReadStream(path).pipe(reply);
  }));
