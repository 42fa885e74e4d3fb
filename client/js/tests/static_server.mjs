// A folder's files by HTTP on a free loopback port, as any server of static files gives them.
import { createReadStream } from 'node:fs';
import { stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';

const kTypes = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm', '.css': 'text/css', '.map': 'application/json' };

export async function serveFolder(folder) {
  const server = createServer(async (request, reply) => {
    const path = join(folder, normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname)));
    const found = await stat(path).catch(() => null);
    if (!found?.isFile()) return reply.writeHead(request.url === '/favicon.ico' ? 204 : 404).end();
    reply.writeHead(200, { 'content-type': kTypes[extname(path)] ?? 'application/octet-stream', 'content-length': found.size });
    createReadStream(path).pipe(reply);
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  return { url: new URL(`http://127.0.0.1:${server.address().port}/`), stop: () => new Promise((done) => (server.closeAllConnections(), server.close(done))) };
}
