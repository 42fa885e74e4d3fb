// What an error of the client means to the person at the page, and what to do.
import { ForelandError, type ErrorCode } from '@foreland/client';
import { reasonOf, sentenceOf } from './words';

const kReload = 'The flight has ended. Reload the page to fly on from here; its console tells more.';
const kWords: Partial<Record<ErrorCode, { title: string; advice: string }>> = {
  module: {
    title: 'The client core did not load.',
    advice: 'Reload the page. If that does not help, the page was built or copied without its foreland.wasm.',
  },
  start: {
    title: 'The client core did not start.',
    advice: 'If memory is short, close other pages. Then reload this one; if it fails again, try another browser.',
  },
  core: { title: 'The client core failed.', advice: kReload },
  worker: {
    title: 'A part of the page did not load.',
    advice: 'Its worker is missing, or this browser cannot run it. Reload the page; if it fails again, try another browser.',
  },
  unsupported: { title: 'This browser cannot run the client core.', advice: 'It needs WebAssembly. Try another browser, or switch WebAssembly on.' },
};

export function wordsOf(error: unknown): { title: string; text: string } {
  const code = error instanceof ForelandError ? error.code : 'client';
  const { title, advice } = kWords[code] ?? { title: 'The page failed.', advice: kReload };
  const reason = error instanceof ForelandError ? error.reason : reasonOf(error);
  return { title, text: reason === '' ? advice : `${sentenceOf(reason)} ${advice}` };
}
