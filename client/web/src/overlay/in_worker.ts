// Has a worker of its own do a task, and ends it: whatever a file does to it, the page goes on, and its memory comes back.
import type { OverlayWork } from './overlay_work';

const kPatience_ms = 120_000;

// An Error says what is wrong with what was given. It is copied.
export function inWorker<K extends keyof OverlayWork>(kind: K, given: OverlayWork[K]['given']): Promise<OverlayWork[K]['made']> {
  const worker = new Worker(new URL('./overlay_worker.ts', import.meta.url), { type: 'module', name: 'overlay' });
  let timer = 0;
  return new Promise<OverlayWork[K]['made']>((done, fail) => {
    timer = setTimeout(() => fail(new Error(`It took more than ${kPatience_ms / 1000} s, and was given up: simplify it, as by ogr2ogr -simplify.`)), kPatience_ms) as unknown as number;
    worker.onmessage = ({ data }: MessageEvent<{ made: OverlayWork[K]['made'] } | { wrong: string }>) => ('wrong' in data ? fail(new Error(data.wrong)) : done(data.made));
    worker.onerror = (event) => fail(new Error(event.message || 'The worker that reads files could not be started.'));
    worker.postMessage({ kind, given });
  }).finally(() => {
    clearTimeout(timer);
    worker.terminate();
  });
}
