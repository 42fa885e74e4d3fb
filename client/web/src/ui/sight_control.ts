// What is seen from here, by hand. Shift-click: the first marks where an eye stands, the next draws a line of sight from it, green as
// far as one sees, red beyond. Key V: drapes over the ground what is seen from that eye, or from the camera; again, or Escape while it
// comes: takes it away.
import type { Place, Sight, Terrain, Vector, Viewshed } from '@foreland/client';
import { spacingOf } from '../measure/measurement';
import { pickExactly } from './exact_pick';
import { isForPage, onClicks, type Stage } from './stage';
import { reasonOf } from './words';

const kEye_m = 1.7; // above what was clicked
const kLift_m = 0.1; // of what is looked at
const kRadius_m = 10_000;
const kCells = 1000; // across a viewshed, at most

export class SightControl {
  private from: Vector | null = null; // where the next line begins
  private sight: Sight | null = null;
  private viewshed: Viewshed | null = null;
  private asking: AbortController | null = null;

  constructor(private readonly stage: Stage) {
    onClicks(stage, (event) => this.click(event));
    window.addEventListener('keydown', (event) => this.key(event));
  }

  // In a picture that took another one's place as well.
  show(): void {
    const { sight_lines, viewshed_drape } = this.stage.picture();
    const up = this.from && this.stage.terrain()?.place(this.from)?.up;
    if (this.from && up) sight_lines.mark(this.from, up);
    else if (this.sight) sight_lines.show(this.sight);
    else sight_lines.clear();
    viewshed_drape.show(this.viewshed);
  }

  // For tests: how much of the viewshed is known, and how many cells are seen.
  status(): Record<string, unknown> {
    const { viewshed, sight, from } = this;
    return {
      sight_marked: from !== null,
      sight_seen: sight?.isSeen ?? null,
      viewshed_known: viewshed ? viewshed.known / viewshed.cells.length : null,
      viewshed_coming: this.asking !== null,
    };
  }

  private click(event: MouseEvent): void {
    if (event.shiftKey) this.run((terrain) => this.point(terrain, event.clientX, event.clientY));
  }
  private key(event: KeyboardEvent): void {
    if (event.repeat || !isForPage(event)) return;
    if (event.code === 'Escape' && this.asking) this.takeAway();
    if (event.code !== 'KeyV') return;
    if (this.asking || this.viewshed) this.takeAway();
    else this.run((terrain) => this.drape(terrain));
  }

  private run(work: (terrain: Terrain) => Promise<void>): void {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene) return;
    work(terrain).catch((error: unknown) => this.stage.say(reasonOf(error)));
  }

  // Of a point of the window that was clicked.
  private async point(terrain: Terrain, x: number, y: number): Promise<void> {
    const { from } = this;
    const point = await pickExactly(terrain, this.stage.picture(), x, y, this.stage.sceneTime());
    if (!point) return this.stage.say('There is no ground to see there.');
    [this.from, this.sight] = from ? [null, await this.look(terrain, from, point)] : [point, null];
    this.show();
    if (!this.sight) this.stage.say('Shift-click where to look to, or press V for all that is seen from here.');
    else if (this.sight.hit) this.stage.say(`Hidden behind ${this.sight.object === null ? 'the ground' : 'an object'}.`);
    else this.stage.say('Seen.');
  }

  private async drape(terrain: Terrain): Promise<void> {
    const asking = (this.asking = new AbortController());
    try {
      this.stage.say('What is seen from here comes in green. Escape ends it.');
      await terrain.viewshed({ ...this.viewshedQuestion(terrain), signal: asking.signal }, (viewshed) => this.take(viewshed));
      this.stage.say(`${seenShare(this.viewshed!)} of the ground around is seen from here. V takes the colours away.`);
    } catch (error) {
      if (asking.signal.aborted) return; // by whoever wants nothing to be said of it
      this.takeAway();
      throw error;
    } finally {
      if (this.asking === asking) this.asking = null;
    }
  }
  private take(viewshed: Viewshed): void {
    this.viewshed = viewshed;
    this.show();
    this.stage.say(`What is seen from here: ${Math.floor((100 * viewshed.known) / viewshed.cells.length)} %. Escape ends it.`);
  }
  private takeAway(): void {
    this.asking?.abort();
    [this.asking, this.viewshed, this.from, this.sight] = [null, null, null, null];
    this.show();
  }

  private viewshedQuestion(terrain: Terrain) {
    const { bounds: { low, high } } = terrain.scene;
    const at = terrain.place(this.from ?? this.stage.picture().eye)!;
    const height = this.from || at.ground === null ? kEye_m : Math.max(at.height - at.ground, 0);
    const across_m = Math.hypot(high[0] - low[0], high[1] - low[1]);
    const radius = Math.min(kRadius_m, across_m);
    const cell = Math.max(spacingOf(terrain), (2 * radius) / kCells);
    return { from: { ...at, height }, radius, cell, sceneTime: this.stage.sceneTime() };
  }

  // As an eye sees that stands on one point, towards another.
  private async look(terrain: Terrain, from: Vector, to: Vector): Promise<Sight> {
    const ends = [raised(terrain.place(from)!, kEye_m), raised(terrain.place(to)!, kLift_m)] as const;
    return (await terrain.visible([ends], { sceneTime: this.stage.sceneTime() }))[0]!;
  }
}

function raised(place: Place, metres: number): Place {
  return { ...place, height: place.height + metres };
}

function seenShare({ cells }: Viewshed): string {
  let [seen, hidden] = [0, 0];
  for (const cell of cells) {
    if (cell === 1) ++seen;
    if (cell === 0) ++hidden;
  }
  return `${((100 * seen) / Math.max(seen + hidden, 1)).toFixed(1)} %`;
}
