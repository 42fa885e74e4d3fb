// Overlays by hand: files of features that are dropped on the page lie on the ground; each has a row that hides it or takes it away, and a
// click on a feature tells what is known of it.
import type { MapPoint, Terrain } from '@foreland/client';
import type { Mark } from '../draw/overlay_drape';
import type { Overlay } from '../overlay/feature';
import { buildGroundGrid, distanceTo, type GroundShape, type Point } from '../overlay/ground_grid';
import { readOverlay } from '../overlay/read_overlay';
import { runInSlices } from '../overlay/slices';
import { onClicks, type Stage } from './stage';

const kNear_px = 8; // of a feature

// What it needs of the page.
export interface OverlayStage extends Stage {
  isTaken(): boolean; // whether clicks are somebody else's now
}

interface Shown {
  overlay: Overlay;
  is_shown: boolean;
  places: Point[][][]; // of each feature's parts, on the lattice
  marks: Mark[];
}

export class OverlayControl {
  private readonly overlays: Shown[] = [];
  private laid = 0; // times that the ground was laid out anew

  constructor(private readonly list: HTMLElement, private readonly card: HTMLElement, private readonly stage: OverlayStage) {
    onClicks(stage, (event) => this.click(event));
  }

  // For tests.
  status(): Record<string, unknown> {
    return { overlays: this.overlays.map(({ overlay, is_shown }) => ({ name: overlay.name, features: overlay.features.length, is_shown })), overlays_laid: this.laid };
  }

  // An Error says what is wrong with the file.
  async add(name: string, bytes: Uint8Array): Promise<void> {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene) throw new Error('There is no scene yet to lay it on.');
    const { frame, crs } = terrain.scene;
    const overlay = await runInSlices(readOverlay(name, bytes, { is_geographic: frame === 'geographic', crs }));
    const shown: Shown = { overlay, is_shown: true, places: await runInSlices(onLattice(terrain, overlay)), marks: await marksOf(terrain, overlay) };
    const same = this.overlays.findIndex((other) => other.overlay.name === name);
    if (same >= 0) this.overlays.splice(same, 1, shown);
    else this.overlays.push(shown);
    await this.layOut();
    this.stage.say([`${name}: ${overlay.features.length.toLocaleString('en')} features lie on the ground.`, ...overlay.notes].join('\n'));
  }

  // In a picture that took another one's place as well.
  async layOut(): Promise<void> {
    this.showRows();
    const mine = ++this.laid;
    const shapes = this.overlays.filter(({ is_shown }) => is_shown).flatMap((shown) => shapesOf(shown));
    const grid = shapes.length > 0 ? await runInSlices(buildGroundGrid(shapes)) : null;
    if (mine !== this.laid) return; // something else is wanted by now
    const { overlay_drape } = this.stage.picture();
    overlay_drape.show(grid);
    overlay_drape.showMarks(this.overlays.filter(({ is_shown }) => is_shown).flatMap(({ marks }) => marks));
  }

  private showRows(): void {
    this.list.replaceChildren(...this.overlays.map((shown) => {
      const row = Object.assign(document.createElement('label'), { className: 'row switch' });
      const title = Object.assign(document.createElement('span'), { textContent: shown.overlay.name, title: shown.overlay.name });
      const input = Object.assign(document.createElement('input'), { type: 'checkbox', checked: shown.is_shown });
      input.onchange = () => {
        shown.is_shown = input.checked;
        void this.layOut();
      };
      const remove = Object.assign(document.createElement('button'), { type: 'button', textContent: '\u00d7', ariaLabel: `Take ${shown.overlay.name} away` });
      remove.onclick = () => {
        this.overlays.splice(this.overlays.indexOf(shown), 1);
        void this.layOut();
      };
      row.append(title, input, remove);
      return row;
    }));
  }

  private click(event: MouseEvent): void {
    const picture = this.stage.picture(), terrain = this.stage.terrain();
    if (event.shiftKey || this.stage.isTaken() || this.overlays.length === 0 || !terrain) return;
    const lattice = (x: number, y: number) => {
      const point = terrain.raycast(picture.eye, picture.directionAt(x, y));
      return point && terrain.place(point)?.lattice;
    };
    const at = lattice(event.clientX, event.clientY), beside = lattice(event.clientX + kNear_px, event.clientY);
    const found = at && beside ? this.find(at, Math.hypot(at[0] - beside[0], at[1] - beside[1])) : null;
    this.showCard(found);
  }

  // The feature that is drawn last of those at a place.
  private find(at: Point, near: number): { title: string; properties: Readonly<Record<string, string>> } | null {
    for (const { overlay, places, is_shown } of [...this.overlays].reverse()) {
      if (!is_shown) continue;
      for (let i = overlay.features.length; i-- > 0;) {
        const feature = overlay.features[i]!;
        if (isAt(feature.kind, places[i]!, at, near)) return { title: feature.name || overlay.name, properties: feature.properties };
      }
    }
    return null;
  }

  private showCard(found: { title: string; properties: Readonly<Record<string, string>> } | null): void {
    this.card.hidden = found === null;
    if (!found) return;
    const rows = Object.entries(found.properties).flatMap(([key, value]) => [
      Object.assign(document.createElement('dt'), { textContent: key }), Object.assign(document.createElement('dd'), { textContent: value })]);
    const list = document.createElement('dl'), close = Object.assign(document.createElement('button'), { type: 'button', textContent: '\u00d7', ariaLabel: 'Close' });
    list.append(...rows);
    close.onclick = () => (this.card.hidden = true);
    const header = document.createElement('header');
    header.append(Object.assign(document.createElement('strong'), { textContent: found.title }), close);
    this.card.replaceChildren(header, list);
  }
}

function* onLattice(terrain: Terrain, overlay: Overlay): Generator<void, Point[][][]> {
  const out: Point[][][] = [];
  for (const { parts } of overlay.features) {
    const of_feature: Point[][] = [];
    for (const part of parts) {
      const places: Point[] = [];
      for (const [i, place] of part.entries()) {
        places.push(terrain.place(terrain.toScene({ ...place, height: 0 }))!.lattice);
        if (i % 256 === 255) yield;
      }
      of_feature.push(places);
      yield;
    }
    out.push(of_feature);
  }
  return out;
}

async function marksOf(terrain: Terrain, overlay: Overlay): Promise<Mark[]> {
  const points = overlay.features.filter(({ kind }) => kind === 'point').flatMap(({ parts, style }) => parts.flat().map((place): [MapPoint, Mark['colour']] => [place, style.stroke]));
  const kAtOnce = 65_536;
  const marks: Mark[] = [];
  for (let begin = 0; begin < points.length; begin += kAtOnce) {
    const some = points.slice(begin, begin + kAtOnce);
    const heights = await terrain.heights(some.map(([place]) => place));
    some.forEach(([place, colour], i) => {
      if (Number.isFinite(heights[i])) marks.push({ point: terrain.toScene({ ...place, height: heights[i]! }), colour });
    });
  }
  return marks;
}

function shapesOf({ overlay, places }: Shown): GroundShape[] {
  return overlay.features.flatMap(({ kind, style }, feature): GroundShape[] => (kind === 'point' ? [] : [{ kind, style, feature, parts: places[feature]! }]));
}

function isAt(kind: Overlay['features'][number]['kind'], parts: readonly (readonly Point[])[], at: Point, near: number): boolean {
  if (kind === 'point') return parts.some((part) => part.some(([x, y]) => Math.hypot(x - at[0], y - at[1]) <= near));
  const isNear = parts.some((part) => part.some((point, i) => i > 0 && distanceTo(at, part[i - 1]!, point) <= near));
  if (kind === 'line' || isNear) return isNear;
  let crossings = 0;
  for (const ring of parts)
    for (let i = 0; i < ring.length; ++i) {
      const [ax, ay] = ring[i]!, [bx, by] = ring[(i + 1) % ring.length]!;
      if (ay > at[1] !== by > at[1] && at[0] < ax + ((bx - ax) * (at[1] - ay)) / (by - ay)) ++crossings;
    }
  return crossings % 2 === 1;
}
