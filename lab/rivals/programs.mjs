// Our own programs, on free loopback ports.
import { execFile, spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { writeFile } from 'node:fs/promises';
import { createConnection, createServer } from 'node:net';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { promisify } from 'node:util';

// Resolves when the program says by an address where it listens.
async function start(program, args) {
  const child = spawn(program, args, { stdio: ['ignore', 'pipe', 'inherit'] });
  const ended = new Promise((done) => child.once('exit', done).once('error', done));
  const port = await new Promise((found, fail) => {
    ended.then((why) => fail(new Error(`${program} ended before it listened: ${why}`)));
    createInterface({ input: child.stdout }).on('line', (line) => {
      const address = line.match(/https?:\/\/[^/\s]*:(\d+)/g)?.at(-1);
      if (address) found(Number(address.match(/(\d+)$/)[1]));
    });
  });
  return { port, stop: () => (child.exitCode === null && child.kill('SIGTERM'), ended) };
}

export const startServer = (bin, scene) => start(join(bin, 'foreland-serve'), [scene, '--listen', '127.0.0.1:0', '--log-level', 'warning']);
export const startLink = (bin, to_port, link) => start(join(bin, 'foreland-link'), ['--listen', '127.0.0.1:0', '--to', `127.0.0.1:${to_port}`, ...link]);

// nginx with HTTP/2 under a certificate of the moment, before a server on another port. `folder` is for its files.
export async function startNginx(folder, to_port) {
  const nginx = '/usr/sbin/nginx';
  if (!existsSync(nginx)) throw new Error(`${nginx} is missing: install nginx, or ask for --protocol http1`);
  const [key, certificate] = ['key.pem', 'certificate.pem'].map((name) => join(folder, name)), port = await freePort();
  await promisify(execFile)('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1', '-nodes', '-days', '2', '-subj', '/CN=127.0.0.1', '-keyout', key, '-out', certificate]);
  const paths = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map((kind) => `${kind}_temp_path ${join(folder, kind)};`).join(' ');
  await writeFile(join(folder, 'nginx.conf'), `daemon off; master_process off; pid ${join(folder, 'nginx.pid')};
events {}
http { access_log off; ${paths} upstream tiles { server 127.0.0.1:${to_port}; keepalive 8; }
  server { listen 127.0.0.1:${port} ssl http2; ssl_certificate ${certificate}; ssl_certificate_key ${key}; keepalive_timeout 600s; keepalive_requests 100000;
    location / { proxy_pass http://tiles; proxy_http_version 1.1; proxy_set_header Connection ""; } } }
`);
  const child = spawn(nginx, ['-p', folder, '-c', join(folder, 'nginx.conf'), '-e', join(folder, 'error.log')], { stdio: 'inherit' });
  const ended = new Promise((done) => child.once('exit', done));
  while (!(await isListening(port))) if (child.exitCode !== null) throw new Error(`nginx ended: ${child.exitCode}`);
  return { port, stop: () => (child.kill(), ended) };
}

const isListening = (port) => new Promise((done) => createConnection(port, '127.0.0.1').once('connect', function () { this.end(); done(true); }).once('error', () => done(false)));

async function freePort() {
  const server = createServer();
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}
