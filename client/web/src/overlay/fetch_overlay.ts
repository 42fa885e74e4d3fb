// Files that an address names.
import { kOverlayFiles } from './file_kinds';

export interface NamedFile {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
}

// An Error says what is wrong, and with what.
export async function fetchOverlay(url: URL, name = nameOf(url)): Promise<NamedFile> {
  if (!/^https?:$/.test(url.protocol)) throw new Error(`${url.href} is no address of the web: write https://\u2026, or a path beside this page.`);
  const reply = await fetch(url).catch(() => {
    throw new Error(`${url.href} did not come: there is no such server, or it does not allow this page to read it (CORS).`);
  });
  if (!reply.ok) throw new Error(`${url.href} did not come: HTTP ${reply.status}.`);
  return { name, bytes: await bounded(reply, name, kOverlayFiles.max_bytes) };
}

function nameOf({ pathname, host }: URL): string {
  const last = pathname.split('/').pop() ?? '';
  try {
    return decodeURIComponent(last) || host;
  } catch {
    return last;
  }
}

// No more than is looked at comes into memory.
async function bounded(reply: Response, name: string, max_bytes: number): Promise<Uint8Array<ArrayBuffer>> {
  const parts: Uint8Array[] = [];
  let size = 0;
  const reader = reply.body!.getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    parts.push(part.value);
    if ((size += part.value.length) <= max_bytes) continue;
    void reader.cancel();
    throw new Error(`${name} has more than ${max_bytes >> 20} MB.`);
  }
  const whole = new Uint8Array(size);
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}

// The files that a server gives everybody (`foreland serve --overlay`); none if it does not say.
export async function overlaysOfServer(files: URL): Promise<{ name: string; url: URL }[]> {
  const reply = await fetch(new URL('overlays/list.json', files)).catch(() => null);
  const list: unknown = reply?.ok ? await reply.json().catch(() => null) : null;
  if (!Array.isArray(list)) return [];
  return list.flatMap((entry: { name?: unknown; path?: unknown } | null) =>
    (typeof entry?.name === 'string' && typeof entry.path === 'string' ? [{ name: entry.name, url: new URL(entry.path, new URL('overlays/', files)) }] : []));
}
