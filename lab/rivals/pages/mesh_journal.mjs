// What becomes of our meshes on their way to the picture, and how early each stage is over. Milliseconds of the page's clock.
const meanOf = (values) => (values.length > 0 ? values.reduce((sum, v) => sum + v, 0) / values.length : null);
const ninthTenth = (values) => [...values].sort((a, b) => a - b)[Math.floor(0.9 * values.length)] ?? null;
const round = (value) => (value === null ? null : Math.round(10 * value) / 10);
const sumOver = (update, of) => Object.values(update.terrain.channels).reduce((sum, channel) => sum + of(channel), 0);

export class MeshJournal {
  meshes = [];
  frames = [];

  // A mesh has come from the worker, which notes its times since 1970.
  add(update, now) {
    const here = (time) => time - performance.timeOrigin, { given, made, posted } = update.times;
    const needed = this.meshes.at(-1)?.to ?? null; // it blends from where the one before it ends
    this.meshes.push({ version: update.version, needed, to: update.to_time_ms, given: here(given), made: here(made), posted: here(posted), came: now, on_card: null, bytes: sumOver(update, ({ data }) => data.byteLength), calls: sumOver(update, ({ ranges }) => ranges.length / 2) });
  }
  // A frame has been made, in so many milliseconds; `ready` is the newest mesh on the card.
  frame(ready, frame, now, took_ms) {
    this.frames.push({ now, took_ms, shown: frame?.version ?? 0, guaranteed_px: frame?.guaranteedPx ?? null });
    for (const mesh of this.meshes) if (mesh.version <= ready) mesh.on_card ??= now;
  }
  // Of the meshes that were needed after `begun`: what each stage takes, and how long before or after it was needed a mesh was there.
  report(begun) {
    const meshes = this.meshes.filter(({ needed, on_card }) => needed !== null && needed > begun && on_card !== null);
    const frames = this.frames.filter(({ now }) => now > begun);
    const stage = (of) => { const values = meshes.map(of); return { mean_ms: round(meanOf(values)), p90_ms: round(ninthTenth(values)) }; };
    return {
      meshes: meshes.length, bytes: Math.round(meanOf(meshes.map(({ bytes }) => bytes))), calls: Math.round(meanOf(meshes.map(({ calls }) => calls))),
      frame_ms: round((frames.at(-1).now - frames[0].now) / (frames.length - 1)), frame_work_ms: round(meanOf(frames.map(({ took_ms }) => took_ms))),
      decoded: stage(({ given, made }) => made - given), copied: stage(({ made, posted }) => posted - made), posted: stage(({ posted, came }) => came - posted), uploaded: stage(({ came, on_card }) => on_card - came),
      late_in_worker: stage(({ given, needed }) => given - needed), late_in_page: stage(({ came, needed }) => came - needed), late_on_card: stage(({ on_card, needed }) => on_card - needed),
    };
  }
  // Of the first meshes that the worker was given after a time: when each stage was over, and when and with what tolerance a frame showed it.
  reportSince(time, most = 6) {
    return this.meshes.filter(({ given }) => given > time).slice(0, most).map(({ version, given, made, posted, came, on_card, bytes }) => {
      const frame = this.frames.find(({ shown }) => shown === version);
      const after = (t) => (t === null ? null : Math.round(t - time));
      return { given: after(given), made: after(made), posted: after(posted), came: after(came), on_card: after(on_card), shown: after(frame?.now ?? null), guaranteed_px: round(frame?.guaranteed_px ?? null), bytes };
    });
  }
}
