// The address of a server's viewers, as people write it: of any of the four schemes, with a path or without.
import { ForelandError } from './errors.js';

const kViewers = 'fly'; // the last part of the path at which a server takes viewers
const kSockets: Record<string, string> = { 'ws:': 'ws:', 'wss:': 'wss:', 'http:': 'ws:', 'https:': 'wss:' };

/** @internal */
export function viewersAt(server: string | URL, token: string | undefined, base?: string): URL {
  let url: URL;
  try {
    url = new URL(server, base);
  } catch (error) {
    throw new ForelandError('address', `"${server}" is no address of a server.`, 'Write it like wss://example.org/.', { cause: error });
  }
  const scheme = kSockets[url.protocol];
  if (!scheme) throw new ForelandError('address', `"${server}" does not say how to connect.`, 'Write it like wss://example.org/, or ws: for a server without TLS.');
  url.protocol = scheme;
  url.hash = '';
  if (url.pathname.endsWith('/')) url.pathname += kViewers;
  if (token !== undefined) url.searchParams.set('token', token);
  return url;
}

/** @internal The address of a server's files, beside its viewers'. */
export function filesAt(viewers: URL): URL {
  const url = new URL('.', viewers);
  url.protocol = url.protocol.replace('ws', 'http');
  url.search = '';
  return url;
}
