// Measuring by hand. The button or key M begins and ends it; each click on the ground adds a corner, Enter adds what is in the middle of the
// view, Backspace takes the last one back, Escape ends it. Measurements that come after others were asked for are dropped.
import type { MapPoint, Place, Terrain, Vector } from '@foreland/client';
import type { Change } from '../measure/change';
import { measure, pointOn, type Measurement } from '../measure/measurement';
import { csvOf, geoJsonOf } from '../measure/measurement_files';
import { pickExactly } from './exact_pick';
import { said } from './language';
import { MeasureCard } from './measure_card';
import { saveFile } from './save_file';
import { dateText } from './scene_time';
import { isForPage, isOnButton, onClicks, type Stage } from './stage';
import { reasonOf } from './words';

export class MeasureControl {
  private corners: MapPoint[] = [];
  private measured: Measurement | null = null;
  private line: Vector[] = [];
  private asked = 0; // measurements so far
  private picks: Promise<unknown> = Promise.resolve(); // of clicks
  private taken_back = 0; // how often corners were
  private is_on = false;
  private readonly card: MeasureCard;
  private readonly button: HTMLButtonElement;

  constructor(tools: HTMLElement, card: HTMLElement, private readonly stage: Stage, cutAlong: (corners: readonly MapPoint[]) => void) {
    this.button = Object.assign(document.createElement('button'), { type: 'button' as const, textContent: said('Measure'), title: 'Points, lines and areas on the exact ground (M)' });
    this.button.onclick = () => this.turn(!this.is_on);
    this.button.setAttribute('aria-pressed', 'false');
    tools.append(this.button);
    this.card = new MeasureCard(card, {
      point: (index) => this.stage.picture().measure_line.point(index === null ? null : this.line[index] ?? null),
      compare: () => this.change(this.corners), save: (kind) => this.save(kind), cut: () => cutAlong(this.measured?.corners ?? []), clear: () => this.takeBackTo([]), close: () => this.turn(false),
    });
    onClicks(stage, (event) => this.click(event));
    window.addEventListener('keydown', (event) => this.key(event));
  }

  // In a picture that took another one's place as well.
  show(): void {
    const { measured } = this, terrain = this.stage.terrain();
    const corners = terrain && measured ? measured.corners.map((corner, i) => pointOn(terrain, corner, measured.heights[i]!.height)) : [];
    this.line = terrain && measured?.profile ? measured.profile.places.map((place, i) => pointOn(terrain, place, measured.profile!.heights[i]!)) : [];
    this.stage.picture().measure_line.show(measured && measured.corners.length > 2 ? [...this.line, corners[0]!] : this.line, corners);
  }

  get isOn(): boolean {
    return this.is_on;
  }

  // For tests.
  status(): Record<string, unknown> {
    const { is_on, measured } = this;
    return { measuring: is_on, measured_corners: measured?.corners.length ?? 0, measured_at: measured?.corners ?? [], measured_m: measured?.profile?.length_m ?? null, measured_m2: measured?.area?.plane_m2 ?? null, measured_change: measured?.change ?? null };
  }

  private turn(is_on: boolean): void {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene) return;
    this.is_on = is_on;
    this.button.setAttribute('aria-pressed', String(is_on));
    document.body.classList.toggle('measuring', is_on);
    this.card.isShown = is_on;
    this.takeBackTo([]);
  }

  private click(event: MouseEvent): void {
    if (this.is_on && !event.shiftKey) this.add(event.clientX, event.clientY);
  }
  private key(event: KeyboardEvent): void {
    if (event.repeat || !isForPage(event) || isOnButton(event)) return;
    if (event.code === 'KeyM') this.turn(!this.is_on);
    if (!this.is_on) return;
    if (event.code === 'Escape') this.turn(false);
    if (event.code === 'Backspace') this.takeBackTo(this.corners.slice(0, -1));
    if (event.code === 'Enter') this.add(window.innerWidth / 2, window.innerHeight / 2);
  }

  // Clicks add corners in their order, however long each one's answer takes; none does once corners were taken back.
  private add(x: number, y: number): void {
    const terrain = this.stage.terrain(), { taken_back } = this;
    if (!terrain?.hasScene) return;
    const picked = pickExactly(terrain, this.stage.picture(), x, y, this.stage.sceneTime()).then((point) => ({ point }), (error: unknown) => ({ error }));
    this.picks = this.picks.then(async () => {
      const found = await picked;
      if (taken_back !== this.taken_back) return;
      if ('error' in found) return this.stage.say(reasonOf(found.error));
      if (!found.point) return this.stage.say('There is no ground to measure there.');
      this.change([...this.corners, mapPointOf(terrain.place(found.point)!)]);
    });
  }
  private takeBackTo(corners: MapPoint[]): void {
    ++this.taken_back;
    this.change(corners);
  }
  private change(corners: MapPoint[]): void {
    this.corners = corners;
    void this.run(async (terrain, isWanted) => {
      if (corners.length === 0) return this.take(terrain, null);
      this.card.show(this.measured, terrain.scene, true);
      const measured = await measure(terrain, corners, this.card.datesOf(terrain.scene, this.stage.sceneTime()));
      if (isWanted()) this.take(terrain, measured);
    });
  }
  private take(terrain: Terrain, measured: Measurement | null): void {
    this.measured = measured;
    this.card.show(measured, terrain.scene, false);
    this.show();
  }
  // `isWanted` turns false once something else is asked.
  private async run(work: (terrain: Terrain, isWanted: () => boolean) => Promise<void> | void): Promise<void> {
    const terrain = this.stage.terrain(), mine = ++this.asked;
    if (!terrain?.hasScene) return;
    try {
      await work(terrain, () => mine === this.asked);
    } catch (error) {
      this.stage.say(reasonOf(error));
      this.card.show(this.measured, terrain.scene, false);
    }
  }

  private save(kind: 'csv' | 'geojson'): void {
    const { measured } = this, terrain = this.stage.terrain();
    if (!measured || !terrain) return;
    if (kind === 'csv' && measured.profile) return saveFile(new Blob([csvOf(measured.profile)], { type: 'text/csv' }), 'profile.csv');
    const properties = { ...(measured.profile ? { length_m: measured.profile.length_m, along_ground_m: measured.profile.surface_m } : {}), ...(measured.area ?? {}), ...(measured.change ? changed(measured.change) : {}) };
    const text = geoJsonOf(measured.corners, measured.heights.map((h) => h.height), terrain.scene.crs, properties, measured.area !== null);
    saveFile(new Blob([text], { type: 'application/geo+json' }), 'measured.geojson');
  }
}

// As a file tells it.
function changed({ since_ms, until_ms, ...volumes }: Change): Record<string, string | number> {
  return { since: dateText(since_ms), until: dateText(until_ms), ...volumes };
}

function mapPointOf(place: Place): MapPoint {
  return 'lat' in place ? { lat: place.lat, lon: place.lon } : { easting: place.easting, northing: place.northing };
}
