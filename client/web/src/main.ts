// Starts the page: checks what the browser can do, loads the client core, runs the app.
import './ui/style.css';
import { App } from './app';
import { Core } from './core/core';
import { showNotice } from './ui/notice';
import { readAddress } from './ui/settings';

declare global {
  interface Window {
    foreland?: { status: () => Record<string, unknown>; compareEnds: () => unknown; shadeAt: App['shadeAt'] };
  }
}

function fail(title: string, text: string): void {
  showNotice(document.getElementById('notice')!, { kind: 'error', title, text });
}

async function main(): Promise<void> {
  if (!document.createElement('canvas').getContext('webgl2')) {
    fail('This browser cannot draw the terrain.', 'It needs WebGL 2. Try a newer browser, or switch hardware acceleration on.');
    return;
  }
  const worker = new Worker(new URL('./core/worker.ts', import.meta.url), { type: 'module' }); // loads while the core does
  let core: Core;
  try {
    core = await Core.load('foreland.wasm');
  } catch (error) {
    fail('The client core did not load.', `${(error as Error).message} Was the page built with foreland.wasm?`);
    return;
  }
  const app = new App(core, worker, readAddress(window.location));
  window.foreland = { status: () => app.status(), compareEnds: () => app.compareEnds(),
    shadeAt: (positions, footprint, weight) => app.shadeAt(positions, footprint, weight) };
  app.start();
}

main().catch((error: Error) => fail('The page failed.', `${error.message} Reload to try again.`));
