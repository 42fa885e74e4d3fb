// The package in Node: a worker thread in the place of a worker, and WebSocket by the package ws where Node has none. No images are
// decoded, so imagery is not asked for.
import { readFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { Worker as Thread } from 'node:worker_threads';
import type { WorkerLike } from './core/session.js';
import { browserHost, setHost } from './host.js';

class NodeWorker implements WorkerLike {
  onmessage: WorkerLike['onmessage'] = null;
  onmessageerror: WorkerLike['onmessageerror'] = null;
  onerror: WorkerLike['onerror'] = null;
  private readonly thread: Thread;
  private did_start = false;

  constructor(url: URL) {
    this.thread = new Thread(url);
    this.thread.on('message', (data) => {
      this.did_start = true;
      this.onmessage?.({ data });
    });
    this.thread.on('messageerror', (error) => this.onmessageerror?.(error));
    this.thread.on('error', (error) => this.onerror?.({ message: error.message, did_start: this.did_start }));
  }
  postMessage(message: unknown): void {
    this.thread.postMessage(message);
  }
  terminate(): void {
    void this.thread.terminate();
  }
}

setHost({
  has_bitmaps: false,
  async loadModule(from) {
    const url = new URL(from ?? './foreland.wasm', import.meta.url);
    return url.protocol === 'file:' ? WebAssembly.compile(await readFile(fileURLToPath(url))) : browserHost.loadModule(url);
  },
  makeWorker: (from) => new NodeWorker(new URL(from ?? './node-worker.js', import.meta.url)),
  watchVisibility: () => () => {},
});

export * from './index.js';
