// Cuts through the ground by hand: across the view (key X), or along what is measured; the other side; away again.
import type { MapPoint, Terrain, Vector } from '@foreland/client';
import { halfOf, kMostCorners, type At } from '../cut/ring';
import { mapOf, wallAlong } from '../cut/wall';
import type { Cut } from '../draw/cut_view';
import { latticeOf } from '../overlay/on_lattice';
import { pickExactly } from './exact_pick';
import { element } from './form';
import { said } from './language';
import { isForPage, isOnButton, type Stage } from './stage';
import { reasonOf } from './words';

export class CutControl {
  private cut: Cut | null = null;
  private ring: readonly MapPoint[] = []; // of the cut that is shown, or asked for
  private is_hole = false;
  private asked = 0;
  private readonly button: HTMLButtonElement;
  private readonly changing: HTMLButtonElement[];

  constructor(tools: HTMLElement, private readonly card: HTMLElement, private readonly stage: Stage) {
    this.button = buttonOf('Cut', 'cut', () => this.open(this.card.hidden === true));
    this.button.title = 'A section through the ground (X)';
    this.button.setAttribute('aria-pressed', 'false');
    tools.append(this.button);
    const header = document.createElement('header'), rows = element('div', 'rows'), close = buttonOf('\u00d7', 'cut_close', () => this.open(false));
    close.ariaLabel = said('Close');
    header.append(Object.assign(document.createElement('strong'), { textContent: said('Cut') }), close);
    this.changing = [buttonOf('Other side', 'cut_turn', () => void this.turnOver()), buttonOf('Clear', 'cut_clear', () => this.clear())];
    const help = Object.assign(element('p', 'help'), { textContent: said('Or measure a line or an area, and cut along it.') });
    rows.append(buttonOf('Across the view', 'cut_across', () => void this.cutAcross()), ...this.changing, help);
    card.append(header, rows);
    this.enable();
    window.addEventListener('keydown', (event) => this.key(event));
  }

  // In a picture that took another one's place.
  show(): void {
    this.stage.picture().showCut(this.cut);
  }

  // Along a line, of whose two sides the farther one is kept, or around what is inside of three corners and more.
  async cutAlong(corners: readonly MapPoint[]): Promise<void> {
    const terrain = this.cuttable();
    if (!terrain) return;
    if (corners.length > kMostCorners) return this.stage.say(`A cut has at most ${kMostCorners} corners.`);
    const places = corners.map((corner) => latticeOf(terrain, corner));
    if (places.length === 2) return this.cutHalf(terrain, places[0]!, places[1]!);
    await this.take(terrain, corners, false);
  }

  // In the page's address, to lead here again.
  write(query: URLSearchParams): void {
    query.delete('cut');
    if (this.ring.length > 0) query.set('cut', [this.is_hole ? 'out' : 'in', ...this.ring.flatMap((at) => numbersOf(at))].join(','));
  }
  async read(text: string | null): Promise<void> {
    const terrain = this.stage.terrain();
    if (text === null || !terrain?.hasScene) return;
    const [side, ...rest] = text.split(','), numbers = rest.map(Number), is_geographic = terrain.scene.frame === 'geographic';
    const corners = Array.from({ length: numbers.length / 2 }, (_, i) => placeOf(numbers[2 * i]!, numbers[2 * i + 1]!, is_geographic));
    const is_sound = (side === 'in' || side === 'out') && numbers.length % 2 === 0 && corners.length > 2 && corners.length <= kMostCorners && numbers.every(Number.isFinite);
    if (!is_sound) return this.stage.say('The cut of this address is none: it is to be like in,8.1,46.2,8.3,46.2,8.2,46.4.');
    if (this.cuttable()) await this.take(terrain, corners, side === 'out');
  }

  // For tests.
  status(): Record<string, unknown> {
    return { cut_corners: this.cut?.ring.length ?? 0, cut_columns: this.cut?.wall.columns ?? 0, cut_hole: this.is_hole };
  }

  private open(is_open: boolean): void {
    this.card.hidden = !is_open;
    this.button.setAttribute('aria-pressed', String(is_open));
  }
  private key(event: KeyboardEvent): void {
    if (event.repeat || event.code !== 'KeyX' || !isForPage(event) || isOnButton(event)) return;
    if (event.shiftKey) void this.turnOver();
    else if (this.ring.length > 0) this.clear();
    else void this.cutAcross();
  }

  // Through what is in the middle of the view, from left to right; what is farther is kept.
  private async cutAcross(): Promise<void> {
    const terrain = this.cuttable(), picture = this.stage.picture();
    if (!terrain) return;
    const [x, y] = [window.innerWidth / 2, window.innerHeight / 2], mine = ++this.asked;
    const at = await pickExactly(terrain, picture, x, y, this.stage.sceneTime()).catch((error: unknown) => this.stage.say(reasonOf(error)));
    if (mine !== this.asked || at === undefined) return;
    if (!at) return this.stage.say('There is no ground in the middle of the view to cut.');
    const way = at.map((v, i) => v - picture.eye[i]!) as Vector, aside: Vector = [at[0] + way[1], at[1] - way[0], at[2]];
    const is_level = Math.hypot(way[0], way[1]) > 1e-3 * Math.hypot(...way);
    const latticeAt = (point: Vector): At => terrain.place(point)!.lattice;
    const here = latticeAt(at), there = latticeAt(is_level ? aside : [at[0] + 1, at[1], at[2]]);
    await this.cutHalf(terrain, here, there);
  }
  private async cutHalf(terrain: Terrain, a: At, b: At): Promise<void> {
    const eye = terrain.place(this.stage.picture().eye)!.lattice, side = (b[0] - a[0]) * (eye[1] - a[1]) - (b[1] - a[1]) * (eye[0] - a[0]);
    const half = side < 0 ? halfOf(terrain.scene.samples, a, b) : halfOf(terrain.scene.samples, b, a);
    if (half.length < 3) return this.stage.say('All of the ground is on one side of that.');
    await this.take(terrain, half.map(mapOf(terrain)), false);
  }

  private async turnOver(): Promise<void> {
    const terrain = this.stage.terrain();
    if (terrain?.hasScene && this.ring.length > 0) await this.take(terrain, this.ring, !this.is_hole);
  }
  private clear(): void {
    ++this.asked;
    this.ring = [];
    this.set(null);
  }

  // Answers that come after another cut are dropped.
  private async take(terrain: Terrain, ring: readonly MapPoint[], is_hole: boolean): Promise<void> {
    const mine = ++this.asked, places = ring.map((corner) => latticeOf(terrain, corner));
    [this.ring, this.is_hole] = [ring, is_hole];
    this.enable();
    try {
      const wall = await wallAlong(terrain, places);
      if (mine === this.asked) this.set({ ring: places, corners: ring.map((corner) => terrain.toScene({ ...corner, height: 0 })), is_hole, wall });
    } catch (error) {
      if (mine === this.asked) this.clear();
      this.stage.say(reasonOf(error));
    }
  }
  private set(cut: Cut | null): void {
    this.cut = cut;
    this.show();
    this.enable();
  }
  private enable(): void {
    for (const button of this.changing) button.disabled = this.ring.length === 0;
  }

  private cuttable(): Terrain | null {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene) return null;
    if (terrain.scene.frame === 'planar' || terrain.scene.frame === 'geographic') return terrain;
    this.stage.say('Globes are not cut.');
    return null;
  }
}

function numbersOf(place: MapPoint): string[] {
  return 'lat' in place ? [place.lon.toFixed(7), place.lat.toFixed(7)] : [place.easting.toFixed(2), place.northing.toFixed(2)];
}
function placeOf(x: number, y: number, is_geographic: boolean): MapPoint {
  return is_geographic ? { lon: x, lat: y } : { easting: x, northing: y };
}
function buttonOf(text: string, name: string, run: () => void): HTMLButtonElement {
  const button = Object.assign(document.createElement('button'), { type: 'button' as const, name, textContent: said(text) });
  button.onclick = run;
  return button;
}
