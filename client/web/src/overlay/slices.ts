// Long work in slices, so that frames are drawn between them. A generator yields where it may be put down.
const kSlice_ms = 6;

export async function runInSlices<T>(work: Generator<void, T>, signal?: AbortSignal): Promise<T> {
  for (;;) {
    const until_ms = performance.now() + kSlice_ms;
    while (performance.now() < until_ms) {
      const { done, value } = work.next();
      if (done) return value;
    }
    await new Promise<void>((go) => setTimeout(go));
    signal?.throwIfAborted();
  }
}
