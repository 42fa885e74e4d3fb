// Starts the page: checks what the browser can do, loads the client core, runs the app.
import './ui/style.css';
import { App } from './app';
import { Core } from './core/core';
import { failureOf, reasonOf, type Failure } from './core/failure';
import { failureOfWorker } from './core/session';
import { sentenceOf } from './core/refusal';
import { canDraw } from './draw/can_draw';
import { wordsOf } from './ui/failure_words';
import { showNotice, type Notice } from './ui/notice';
import { serverAddress } from './ui/server_address';
import { readAddress, type Address } from './ui/settings';

declare global {
  interface Window {
    foreland?: { status: () => Record<string, unknown>; compareEnds: () => unknown; shadeAt: App['shadeAt'] };
  }
}

let has_failed = false;

// The first failure is the one that is shown.
const kReload = { label: 'Reload the page', run: () => window.location.reload() };
function fail(title: string, text: string, action: Notice['action'] = kReload): void {
  if (has_failed) return;
  has_failed = true;
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
  if (!canDraw())
    return fail('This browser cannot draw the terrain.', 'It needs WebGL 2. Try a newer browser, or switch hardware acceleration on.');
  if (typeof WebAssembly === 'undefined')
    return fail('This browser cannot run the client core.', 'It needs WebAssembly. Try another browser, or switch WebAssembly on.');
  const query = new URLSearchParams(window.location.search);
  const server = serverAddress(query.get('server'), window.location.href);
  if (!('url' in server)) return refuse(server, query);
  const address = readAddress(window.location, server.url);
  const worker = new Worker(new URL('./core/worker.ts', import.meta.url), { type: 'module' }); // loads while the core does
  worker.onerror = (event) => failBy(failureOfWorker(event)); // until the app listens
  fly(worker, address).catch((error: unknown) => {
    worker.terminate();
    console.error(error);
    failBy(failureOf(error));
  });
}

// An address in ?server= that will not do, with one that may.
function refuse({ title, text, better }: Exclude<ReturnType<typeof serverAddress>, { url: string }>, query: URLSearchParams): void {
  if (better === null) return fail(title, text);
  const run = () => {
    query.set('server', better);
    window.location.search = query.toString();
  };
  fail(title, text, { label: `Connect to ${better}`, run });
}

try {
  main();
} catch (error) {
  console.error(error);
  failBy(failureOf(error));
}
