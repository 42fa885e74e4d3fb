// How a terrain begins: its worker and its module, and how long one waits for its session.
import { Core } from './core/core.js';
import { failureOfWorker, type WorkerLike } from './core/session.js';
import type { Failure } from './core/failure.js';
import { ForelandError } from './errors.js';
import { moduleOf, theHost } from './host.js';
import type { OpenOptions } from './options.js';

function isWorker(worker: OpenOptions['worker']): worker is Worker {
  return typeof worker === 'object' && !(worker instanceof URL);
}

/** @internal The worker is there at once, and loads while the module does. Throws where there can be none. */
export function makeWorker({ worker }: OpenOptions, onFailure: (failure: Failure) => void): WorkerLike {
  if (typeof WebAssembly === 'undefined') throw new ForelandError('unsupported', 'WebAssembly is missing here.', 'Try another browser, or switch WebAssembly on.');
  const made: WorkerLike = isWorker(worker) ? worker : theHost().makeWorker(worker);
  made.onerror = (event) => onFailure(failureOfWorker(event));
  return made;
}

/** @internal */
export async function loadCore({ wasm }: OpenOptions): Promise<Core> {
  return Core.load(await moduleOf(wasm));
}

/** @internal After so long `late` is called with what to tell; gives what ends the waiting. `reason` is the last word of the connection. */
export function awaitSession(server: string, patience_ms: number, reason: () => string, late: (error: ForelandError) => void): () => void {
  if (patience_ms === Infinity) return () => {};
  const timer = setTimeout(() => late(new ForelandError('unreachable', `No session with ${server} began in ${patience_ms / 1000} s. ${reason()}`.trim(),
    'Look whether the server runs there, and whether this page may reach it.')), patience_ms);
  return () => clearTimeout(timer);
}
