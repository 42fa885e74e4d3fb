// Starts the page: checks what the browser can do and where the server is, and runs the app.
import './ui/style.css';
import { App } from './app';
import { canDraw } from './draw/can_draw';
import { wordsOf } from './ui/failure_words';
import { languageOf, setLanguage } from './ui/language';
import { showNotice, type Notice } from './ui/notice';
import { serverAddress } from './ui/server_address';
import { readAddress } from './ui/settings';

declare global {
  interface Window {
    foreland?: { status: () => Record<string, unknown>; compareEnds: () => unknown; shadeAt: App['shadeAt']; groundAt: App['groundAt']; onScreen: App['onScreen'] };
  }
}

const kReload = { label: 'Reload the page', run: () => window.location.reload() };
function fail(title: string, text: string, action: Notice['action'] = kReload): void {
  showNotice(document.getElementById('notice')!, { kind: 'error', title, text, action });
}

function main(): void {
  if (!canDraw())
    return fail('This browser cannot draw the terrain.', 'It needs WebGL 2. Try a newer browser, or switch hardware acceleration on.');
  if (typeof WebAssembly === 'undefined')
    return fail('This browser cannot run the client core.', 'It needs WebAssembly. Try another browser, or switch WebAssembly on.');
  const query = new URLSearchParams(window.location.search);
  setLanguage(languageOf(query.get('lang'), navigator.languages));
  const server = serverAddress(query.get('server'), window.location.href);
  if (!('url' in server)) return refuse(server, query);
  const app = new App(readAddress(window.location, server.url));
  window.foreland = { status: () => app.status(), compareEnds: () => app.compareEnds(),
    shadeAt: (positions, footprint, weight) => app.shadeAt(positions, footprint, weight),
    groundAt: (x, y) => app.groundAt(x, y), onScreen: (point) => app.onScreen(point) };
  app.start();
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
  const { title, text } = wordsOf(error);
  fail(title, text);
}
