// What a failure means to the person at the page, and what to do.
import type { FailedPart, Failure } from '../core/failure';
import { sentenceOf } from '../core/refusal';

const kWords: Record<FailedPart, { title: string; advice: string }> = {
  'core start': {
    title: 'The client core did not start.',
    advice: 'If memory is short, close other pages. Then reload this one; if it fails again, try another browser.',
  },
  'core': { title: 'The client core failed.', advice: 'The flight has ended. Reload the page to fly on from here; its console tells more.' },
  'worker start': {
    title: 'A part of the page did not load.',
    advice: 'Its worker is missing, or this browser cannot run it. Reload the page; if it fails again, try another browser.',
  },
  'page': { title: 'The page failed.', advice: 'The flight has ended. Reload the page to fly on from here; its console tells more.' },
};

export function wordsOf({ part, reason }: Failure): { title: string; text: string } {
  const { title, advice } = kWords[part];
  return { title, text: reason === '' ? advice : `${sentenceOf(reason)} ${advice}` };
}
