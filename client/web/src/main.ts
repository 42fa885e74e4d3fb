// Starts the page: checks what the browser can do, loads the client core, runs the app.
import './ui/style.css';
import { App } from './app';
import { Core } from './core/core';
import { failureOf, reasonOf, type Failure } from './core/failure';
import { failureOfWorker } from './core/session';
import { sentenceOf, wordsOf } from './ui/failure_words';
import { showNotice } from './ui/notice';
import { readAddress, type Address } from './ui/settings';

declare global {
  interface Window {
    foreland?: { status: () => Record<string, unknown>; compareEnds: () => unknown; shadeAt: App['shadeAt'] };
  }
}

let has_failed = false;

// The first failure is the one that is shown.
function fail(title: string, text: string): void {
  if (has_failed) return;
  has_failed = true;
  const action = { label: 'Reload the page', run: () => window.location.reload() };
  showNotice(document.getElementById('notice')!, { kind: 'error', title, text, action });
}
function failBy(failure: Failure): void {
  const { title, text } = wordsOf(failure);
  fail(title, text);
}

async function loadCore(): Promise<Core | null> {
  try {
    return await Core.load('foreland.wasm');
  } catch (error) {
    console.error(error);
    fail('The client core did not load.', `${sentenceOf(reasonOf(error))} Reload the page. If that does not help, the page was built or copied without its foreland.wasm.`);
    return null;
  }
}

async function fly(worker: Worker, address: Address): Promise<void> {
  const core = await loadCore();
  if (!core || has_failed) return worker.terminate();
  const app = new App(core, worker, address);
  window.foreland = { status: () => app.status(), compareEnds: () => app.compareEnds(),
    shadeAt: (positions, footprint, weight) => app.shadeAt(positions, footprint, weight) };
  app.start();
}

function main(): void {
  if (!document.createElement('canvas').getContext('webgl2'))
    return fail('This browser cannot draw the terrain.', 'It needs WebGL 2. Try a newer browser, or switch hardware acceleration on.');
  if (typeof WebAssembly === 'undefined')
    return fail('This browser cannot run the client core.', 'It needs WebAssembly. Try another browser, or switch WebAssembly on.');
  const address = readAddress(window.location);
  if (!isServerAddress(address.server))
    return fail('There is no such server.', `"${address.server}" in the page's address is to be like wss://example.org/fly.`);
  const worker = new Worker(new URL('./core/worker.ts', import.meta.url), { type: 'module' }); // loads while the core does
  worker.onerror = (event) => failBy(failureOfWorker(event)); // until the app listens
  fly(worker, address).catch((error: unknown) => {
    worker.terminate();
    console.error(error);
    failBy(failureOf(error));
  });
}

function isServerAddress(server: string): boolean {
  try {
    return /^wss?:$/.test(new URL(server).protocol);
  } catch {
    return false;
  }
}

try {
  main();
} catch (error) {
  console.error(error);
  failBy(failureOf(error));
}
