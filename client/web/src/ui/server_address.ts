// Which server the page connects to: the one beside it, or the one that ?server= names; or what is wrong with that, and what would do.
export type ServerAddress = { url: string } | { title: string; text: string; better: string | null };

const kViewers = 'fly'; // the last part of the path at which a server takes viewers
const kSockets: Record<string, string> = { 'ws:': 'ws:', 'wss:': 'wss:', 'http:': 'ws:', 'https:': 'wss:' };

// `page` is the page's own address.
export function serverAddress(wanted: string | null, page: string): ServerAddress {
  if (wanted === null) return { url: socketAt(new URL(kViewers, page)).href };
  const given = parsed(wanted);
  const own_scheme = kSockets[new URL(page).protocol] ?? 'ws:';
  if (!given || !kSockets[given.protocol]) return unknown(wanted, own_scheme);
  const server = socketAt(given);
  if (own_scheme !== 'wss:' || server.protocol === 'wss:' || isThisMachine(server.hostname)) return { url: server.href };
  return {
    title: 'The browser does not connect to this server.',
    text: `This page came by https, so browsers let it connect by wss: alone, and not to ${server.href}. Give the server a certificate ` +
      '(--tls-cert, or a proxy before it), or open this page by http.',
    better: Object.assign(new URL(server), { protocol: 'wss:' }).href,
  };
}

// As foreland fly takes addresses: of any of the four schemes, with a path or without.
function socketAt(address: URL): URL {
  const url = new URL(address);
  url.protocol = kSockets[address.protocol] ?? 'ws:';
  url.hash = '';
  if (url.pathname.endsWith('/')) url.pathname += kViewers;
  return url;
}

function unknown(wanted: string, scheme: string): ServerAddress {
  const title = 'There is no such server.';
  const guess = /^\w[\w.-]*(:\d+)?(\/|$)|^\[/.test(wanted.replace(/^\/\//, '')) ? parsed(`${scheme}//${wanted.replace(/^\/\//, '')}`) : null;
  if (!guess) return { title, text: `"${wanted}" in the page's address is to be like wss://example.org/fly.`, better: null };
  const better = socketAt(guess).href;
  return { title, text: `"${wanted}" in the page's address does not say how to connect: write server=${better}, or wss: for a server with TLS.`, better };
}

function parsed(text: string): URL | null {
  try {
    return new URL(text);
  } catch {
    return null;
  }
}

// Browsers take these for safe without TLS.
function isThisMachine(host: string): boolean {
  return /^(localhost|.*\.localhost|127(\.\d+){3}|\[::1\])$/.test(host);
}
