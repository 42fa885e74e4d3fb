// The package as one file, with the worker and the module in it: for pages without a bundler, and for bundlers that lose workers. The
// page's Content-Security-Policy is to allow workers of blob: addresses.
import module_bytes from 'foreland:wasm';
import worker_text from 'foreland:worker';
import { browserHost, setHost } from './host.js';

let address: string | null = null; // of the worker's script, for all terrains

setHost({
  ...browserHost,
  loadModule: (from) => (from === undefined ? WebAssembly.compile(module_bytes) : browserHost.loadModule(from)),
  makeWorker(from) {
    if (from !== undefined) return browserHost.makeWorker(from);
    address ??= URL.createObjectURL(new Blob([worker_text], { type: 'text/javascript' }));
    return new Worker(address, { type: 'module' });
  },
});

export * from './index.js';
