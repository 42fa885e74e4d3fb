// Why a WebSocket did not open. Browsers do not say, so the same address is asked by plain HTTP: Foreland's server answers that as it
// answers the WebSocket, and 426 if it would have let it in, so something on the way has not passed the WebSocket on.
const kPatience_ms = 5000;
const kLongest = 300; // of what is shown of an answer

const kLostUpgrade = 'The server is there, but no WebSocket gets to it: a proxy on the way does not pass Upgrade on. nginx needs ' +
  'proxy_http_version 1.1, proxy_set_header Upgrade and proxy_set_header Connection (docs/PUBLIC_PORT.md).';

// Sentences; empty if nothing answers, or nothing that the page may read. Never rejects.
export async function askWhy(url: string): Promise<string> {
  try {
    const reply = await fetch(url.replace(/^ws/, 'http'), { cache: 'no-store', redirect: 'manual', signal: AbortSignal.timeout(kPatience_ms) });
    if (reply.type === 'opaqueredirect') return 'Its address leads elsewhere, as to a sign-on that has to be renewed: reload the page.';
    const is_text = /^text\/plain/.test(reply.headers.get('content-type') ?? '');
    return whyOf(reply.status, reply.statusText, is_text ? await reply.text() : '');
  } catch {
    return '';
  }
}

// Of an answer, and what it says in plain text.
export function whyOf(status: number, status_text: string, text: string): string {
  const line = text.replace(/\s+/g, ' ').trim();
  const said = line === '' ? '' : `The server said: ${line.length > kLongest ? `${line.slice(0, kLongest)}\u2026` : sentenceOf(line)}`;
  const name = `HTTP ${status}${status_text === '' ? '' : ` ${status_text}`}`;
  if (status === 426) return [kLostUpgrade, said].filter((part) => part !== '').join(' ');
  if (status < 400 || status === 404) return [`What answers there is no server of terrain (${name}).`, said].filter((part) => part !== '').join(' ');
  return said === '' ? `The server, or a proxy before it, answers ${name}.` : said;
}

export function sentenceOf(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}
