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

// Where this script was loaded from; webpack says where it lay as it was built, file:.
const here = import.meta.url;
const isElsewhere = (url: URL) => typeof location !== 'undefined' && /^https?:$/.test(url.protocol) && url.origin !== location.origin;

// A worker of another origin is not allowed; a script of our own that imports it is.
function workerAt(url: URL): Worker {
  if (!isElsewhere(url)) return new Worker(url, { type: 'module' });
  const text = URL.createObjectURL(new Blob([`import ${JSON.stringify(url.href)};`], { type: 'text/javascript' }));
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
  makeWorker(from) {
    if (from !== undefined) return workerAt(new URL(from, here));
    if (isElsewhere(new URL(here))) return workerAt(new URL(['./worker', 'js'].join('.'), here));
    return new Worker(new URL('./worker.js', import.meta.url), { type: 'module' }); // bundlers know these very words
  },
  watchVisibility: watchDocument,
};

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
