// What a client needs of where it runs: the module, a worker, and whether anybody looks. Browsers are the default; node.ts and inline.ts
// put others in its place.
import { reasonOf } from './core/failure.js';
import type { WorkerLike } from './core/session.js';
import { ForelandError } from './errors.js';

/** @internal */
export interface Host {
  readonly has_bitmaps: boolean; // images can be decoded
  loadModule(from: URL | string | undefined): Promise<WebAssembly.Module>;
  makeWorker(from: URL | string | undefined): WorkerLike;
  // Calls `onChange` whenever what is drawn begins or ceases to be seen; gives what ends that.
  watchVisibility(onChange: (is_hidden: boolean) => void): () => void;
}

const kAdvice = 'Serve foreland.wasm beside the package, pass its address or a compiled module as `wasm`, or import @foreland/client/inline.';

async function fetchModule(url: URL | string): Promise<WebAssembly.Module> {
  let response: Response;
  try {
    response = await fetch(url);
  } catch (error) {
    throw new ForelandError('module', `${url} did not load: ${reasonOf(error)}.`, kAdvice, { cause: error });
  }
  if (!response.ok) throw new ForelandError('module', `${url}: HTTP ${response.status}.`, kAdvice);
  try {
    return await WebAssembly.compile(await response.arrayBuffer());
  } catch (error) {
    throw new ForelandError('module', `${url} is no WebAssembly module: ${reasonOf(error)}.`, kAdvice, { cause: error });
  }
}

// A worker of another origin is not allowed; a script of our own that imports it is.
function workerAt(url: URL | string): Worker {
  const address = new URL(url, import.meta.url);
  if (typeof location === 'undefined' || address.origin === location.origin || !/^https?:$/.test(address.protocol)) return new Worker(address, { type: 'module' });
  const text = URL.createObjectURL(new Blob([`import ${JSON.stringify(address.href)};`], { type: 'text/javascript' }));
  const worker = new Worker(text, { type: 'module' });
  setTimeout(() => URL.revokeObjectURL(text), 60_000);
  return worker;
}

/** @internal */
export function watchDocument(onChange: (is_hidden: boolean) => void): () => void {
  if (typeof document === 'undefined') return () => {};
  const tell = () => onChange(document.hidden);
  document.addEventListener('visibilitychange', tell);
  if (document.hidden) tell();
  return () => document.removeEventListener('visibilitychange', tell);
}

/** @internal */
export const browserHost: Host = {
  has_bitmaps: true,
  loadModule: (from) => fetchModule(from ?? new URL('./foreland.wasm', import.meta.url)),
  // Bundlers know the words of the first of these, and would take those of the second for another file.
  makeWorker: (from) => (from === undefined && isOwnOrigin() ? new Worker(new URL('./worker.js', import.meta.url), { type: 'module' })
    : workerAt(from ?? new URL(['./worker', 'js'].join('.'), import.meta.url))),
  watchVisibility: watchDocument,
};

function isOwnOrigin(): boolean {
  return typeof location === 'undefined' || new URL(import.meta.url, location.href).origin === location.origin;
}

let host: Host = browserHost;
/** @internal */
export const theHost = (): Host => host;
/** @internal */
export function setHost(other: Host): void {
  host = other;
}

// Compiled once for all terrains of a page, by address; one that did not load is tried again.
const modules = new Map<string, Promise<WebAssembly.Module>>();
/** @internal */
export function moduleOf(from: URL | string | WebAssembly.Module | undefined): Promise<WebAssembly.Module> {
  if (from instanceof WebAssembly.Module) return Promise.resolve(from);
  const key = String(from ?? '');
  const known = modules.get(key);
  if (known) return known;
  const loading = host.loadModule(from);
  modules.set(key, loading);
  loading.catch(() => modules.delete(key));
  return loading;
}
