// Overlays by hand: files of features that are dropped on the page, named in its address or given by the server lie on the ground; each has
// a row that hides it or takes it away, and a click on a feature tells what is known of it.
import type { Terrain, Vector } from '@foreland/client';
import { metNow } from '../cut/rays';
import type { Mark } from '../draw/overlay_marks';
import type { Picture } from '../draw/picture';
import type { Feature, Laid, Overlay } from '../overlay/feature';
import { fetchOverlay, overlaysOfServer } from '../overlay/fetch_overlay';
import { featureAt, pointedAt } from '../overlay/find_feature';
import { inWorker } from '../overlay/in_worker';
import { isWithin, mapPointsOf, onLattice } from '../overlay/on_lattice';
import type { FlatShape } from '../overlay/overlay_work';
import { runInSlices } from '../overlay/slices';
import { FeatureCard } from './feature_card';
import type { LabelControl } from './label_control';
import { element } from './form';
import { onClicks, type Stage } from './stage';
import { reasonOf } from './words';

const kNear_px = 5; // beside a line
const kStep_px = 4; // between places of the ground that say how it lies
const kHeightsAtOnce = 65_536; // that a server is asked for

// What it needs of the page.
export interface OverlayStage extends Stage {
  isTaken(): boolean; // whether clicks are somebody else's now
  refuse(reason: string): void; // tells what is wrong with a file
}

interface Shown {
  overlay: Overlay;
  is_shown: boolean;
  laid: Laid[]; // each feature, on the lattice
  marks: Mark[];
}

export class OverlayControl {
  private readonly overlays: Shown[] = [];
  private readonly card: FeatureCard;
  private asked = 0; // times that the ground was to be laid out anew
  private laid = 0;

  constructor(private readonly list: HTMLElement, card: HTMLElement, private readonly stage: OverlayStage, private readonly labels: LabelControl) {
    this.card = new FeatureCard(card);
    onClicks(stage, (event) => this.click(event));
  }

  // For tests.
  status(): Record<string, unknown> {
    return { overlays: this.overlays.map(({ overlay, is_shown }) => ({ name: overlay.name, features: overlay.features.length, is_shown })), overlays_laid: this.laid };
  }

  // Those of the server and those that the page's address names; once there is a scene.
  async open(addresses: readonly string[]): Promise<void> {
    const terrain = this.stage.terrain();
    if (!terrain) return;
    const named = addresses.map((text) => () => fetchOverlay(addressOf(text)));
    const given = (await overlaysOfServer(terrain.files)).map(({ name, url }) => () => fetchOverlay(url, name));
    for (const fetchIt of [...given, ...named]) {
      try {
        const { name, bytes } = await fetchIt();
        await this.add(name, bytes);
      } catch (error) {
        this.stage.refuse(reasonOf(error));
      }
    }
  }

  // An Error says what is wrong with the file. One of the same name is replaced.
  async add(name: string, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene) throw new Error('There is no scene yet to lay it on.');
    const { frame, crs } = terrain.scene;
    const overlay = await inWorker('read', { name, bytes, map: { is_geographic: frame !== 'planar', crs } });
    const laid = await runInSlices(onLattice(terrain, overlay.features));
    if (!isWithin(terrain, laid)) throw new Error(await outsideText(terrain, overlay));
    const shown: Shown = { overlay, is_shown: true, laid, marks: await marksOf(terrain, overlay) };
    const same = this.overlays.findIndex((other) => other.overlay.name === name);
    this.overlays.splice(same < 0 ? this.overlays.length : same, same < 0 ? 0 : 1, shown);
    try {
      await this.layOut();
    } catch (error) {
      this.takeAway(shown);
      throw new Error(`${name}: ${reasonOf(error)}`);
    }
    const count = overlay.features.length;
    this.stage.say([`${name}: ${count.toLocaleString('en')} ${count === 1 ? 'feature lies' : 'features lie'} on the ground.`, ...overlay.notes].join('\n'));
  }

  // In a picture that took another one's place.
  showAgain(): void {
    if (this.overlays.length > 0) this.layOutAgain();
  }

  private async layOut(): Promise<void> {
    this.showRows();
    const mine = ++this.asked;
    const seen = this.overlays.filter(({ is_shown }) => is_shown);
    const shapes = seen.flatMap(shapesOf);
    const grid = shapes.length > 0 ? await inWorker('lay', { shapes }) : null;
    if (mine !== this.asked) return; // something else is wanted by now
    const { overlay_drape, overlay_marks } = this.stage.picture();
    overlay_drape.show(grid);
    const marks = seen.flatMap((shown) => shown.marks), terrain = this.stage.terrain();
    overlay_marks.show(marks);
    if (terrain) this.labels.setMarks(terrain, marks);
    this.laid = mine;
  }

  private layOutAgain(): void {
    this.card.show(null);
    this.layOut().catch((error: unknown) => this.stage.refuse(reasonOf(error)));
  }
  private takeAway(shown: Shown): void {
    this.overlays.splice(this.overlays.indexOf(shown), 1);
    this.layOutAgain();
  }

  private showRows(): void {
    this.list.replaceChildren(...this.overlays.map((shown) => this.rowOf(shown)));
  }
  private rowOf(shown: Shown): HTMLElement {
    const { name } = shown.overlay;
    const row = element('div', 'row switch'), label = element('label');
    const input = Object.assign(document.createElement('input'), { type: 'checkbox', checked: shown.is_shown, ariaLabel: `Show ${name}` });
    input.onchange = () => {
      shown.is_shown = input.checked;
      this.layOutAgain();
    };
    label.append(Object.assign(element('span'), { textContent: name, title: name }), input);
    row.append(label, Object.assign(document.createElement('button'), { type: 'button', textContent: '\u00d7', ariaLabel: `Take ${name} away`, onclick: () => this.takeAway(shown) }));
    return row;
  }

  private click(event: MouseEvent): void {
    const terrain = this.stage.terrain();
    if (event.shiftKey || this.stage.isTaken() || this.overlays.length === 0 || !terrain) return;
    this.card.show(this.find(terrain, event.clientX, event.clientY));
  }

  // What is drawn last of what is at a point of the window; marks stand above all else.
  private find(terrain: Terrain, x: number, y: number): { title: string; properties: Readonly<Record<string, string>> } | null {
    const picture = this.stage.picture();
    const seen = this.overlays.filter(({ is_shown }) => is_shown).reverse();
    const cardOf = ({ overlay }: Shown, { name, properties }: Feature) => ({ title: name || overlay.name, properties });
    for (const shown of seen) {
      const mark = picture.overlay_marks.markAt(shown.marks, x, y, (point) => picture.pointOnScreen(point), (point) => isSeen(terrain, picture, point));
      if (mark) return cardOf(shown, mark.feature);
    }
    const placeAt = (at_x: number, at_y: number) => {
      const met = picture.metAt(at_x, at_y);
      return met && !met.is_wall ? terrain.place(met.point)?.lattice : null;
    };
    const [at, right, below] = [placeAt(x, y), placeAt(x + kStep_px, y), placeAt(x, y + kStep_px)];
    if (!at || !right || !below) return null;
    for (const shown of seen) {
      const feature = featureAt(shown.overlay.features, shown.laid, pointedAt(at, right, below, kStep_px), kNear_px);
      if (feature) return cardOf(shown, feature);
    }
    return null;
  }
}

function addressOf(text: string): URL {
  try {
    return new URL(text, window.location.href);
  } catch {
    throw new Error(`"${text}" in the page's address is no address of a file.`);
  }
}

async function outsideText(terrain: Terrain, { name, features }: Overlay): Promise<string> {
  const exchanged = features.map((feature) => ({ ...feature, parts: feature.parts.map((part) => part.map((_, i) => part[i ^ 1]!)) }));
  const is_exchanged = terrain.scene.frame !== 'planar' && isWithin(terrain, await runInSlices(onLattice(terrain, exchanged)));
  return is_exchanged ? `${name} lies outside of this scene: its axes seem to be exchanged, GeoJSON has longitude first.` : `${name} lies outside of this scene.`;
}

// A mark that is drawn stands a little nearer than its place.
function isSeen(terrain: Terrain, { eye, cut_view }: Picture, point: Vector): boolean {
  const to = point.map((v, i) => eye[i]! + 0.98 * (v - eye[i]!)) as Vector;
  return metNow(terrain, cut_view.shown, { from: eye, to }) === null;
}

async function marksOf(terrain: Terrain, { features }: Overlay): Promise<Mark[]> {
  const points = features.filter(({ kind }) => kind === 'point').flatMap((feature) => feature.parts.flatMap((part) => mapPointsOf(terrain, part).map((place) => ({ place, feature }))));
  const marks: Mark[] = [];
  for (let begin = 0; begin < points.length; begin += kHeightsAtOnce) {
    const some = points.slice(begin, begin + kHeightsAtOnce);
    const heights = await terrain.heights(some.map(({ place }) => place));
    some.forEach(({ place, feature }, i) => {
      if (!Number.isFinite(heights[i])) return;
      const point = terrain.toScene({ ...place, height: heights[i]! });
      marks.push({ point, lattice: terrain.place(point)!.lattice, feature });
    });
  }
  return marks;
}

function shapesOf({ overlay, laid }: Shown): FlatShape[] {
  return overlay.features.flatMap(({ kind, style }, feature): FlatShape[] => {
    const { outline, rings } = laid[feature]!;
    if (kind === 'point') return [];
    if (kind === 'line' || outline === rings) return [{ kind, style, feature, parts: outline }];
    return [{ kind, style: { ...style, stroke_px: 0 }, feature, parts: rings }, { kind: 'line', style, feature, parts: outline }];
  });
}
