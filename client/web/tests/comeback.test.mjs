// When the page tries to draw again after the graphics card was reset.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openSources } from './support.mjs';

let sources, Comeback;
before(async () => {
  sources = await openSources();
  ({ Comeback } = await sources.load('draw/comeback.ts'));
});
after(() => sources?.close());

test('it draws again at once, and waits longer where the card is reset again and again', () => {
  const comeback = new Comeback();
  let now_ms = 100_000;
  const waits = Array.from({ length: 8 }, () => {
    const wait_ms = comeback.next(now_ms);
    now_ms += wait_ms + 10;
    return wait_ms;
  });
  assert.deepEqual(waits, [0, 500, 1000, 2000, 4000, 8000, 8000, 8000]);
  assert.equal(comeback.next(now_ms + 31_000), 0, 'after a calm while the next one is a first one');
});
