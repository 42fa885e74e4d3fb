// Names of an overlay's points, written over the ground: those that are in sight, by the server's exact lines of sight, as many as fit.
import type { Terrain, Vector } from '@foreland/client';
import { metExactly } from '../cut/rays';
import type { At } from '../cut/ring';
import { isKept } from '../cut/spans';
import type { Cut } from '../draw/cut_view';
import type { Mark } from '../draw/overlay_marks';
import type { NameText } from '../draw/name_texts';
import { importanceOf, writable } from '../overlay/names';
import { LabelLayout, type LabelCandidate } from './label_layout';
import type { Stage } from './stage';

const kMostNames = 5000; // that are looked at, the most important ones
const kMostCandidates = 150; // in a frame
const kAskEvery_ms = 250;
const kAbove_m = 3; // the ground, so that it does not hide its own point

interface Name extends NameText {
  importance: number;
  above: Vector; // what has to be seen
  lattice: At;
  is_seen: boolean;
}

export class LabelControl {
  private names: Name[] = [];
  private readonly layout = new LabelLayout();
  private is_on = true;
  private asked_ms = -Infinity;
  private asked_at = ''; // where the eye was, and for whom
  private asked_cut: Cut | null = null;
  private is_asking = false;
  private shown: ReadonlySet<number> = new Set();
  private asked = 0; // questions of sight
  private given = 0; // names, ever

  constructor(private readonly stage: Stage) {}

  // For tests.
  status(): Record<string, unknown> {
    return { labels: this.names.filter(({ id }) => this.shown.has(id)).map(({ text }) => text), names: this.names.length, sights_asked: this.asked };
  }

  setOn(is_on: boolean): void {
    this.is_on = is_on;
    if (!is_on) this.clear();
  }
  // The points that are shown now.
  setMarks(terrain: Terrain, marks: readonly Mark[]): void {
    const named = marks.map((mark) => ({ mark, text: writable(mark.feature.name) })).filter(({ text }) => text !== '');
    const ranked = named.map((each) => ({ ...each, importance: importanceOf(each.mark.feature) })).sort((a, b) => a.importance - b.importance).slice(0, kMostNames);
    this.clear();
    this.names = ranked.map(({ mark: { point, lattice, feature }, text, importance }) => {
      const place = terrain.toGeodetic(point), above = terrain.toScene({ ...place, height: place.height + kAbove_m });
      return { id: ++this.given, text, point, lift_px: feature.style.marker_px, importance, above, lattice, is_seen: false };
    });
  }

  // After each frame that is drawn.
  update(now_ms: number): void {
    const terrain = this.stage.terrain();
    if (!this.is_on || !terrain?.hasScene || this.names.length === 0) return;
    const { candidates, seen_by } = this.inView();
    this.shown = this.layout.update(now_ms, candidates);
    this.stage.picture().name_texts.show(this.shown);
    this.askSight(terrain, now_ms, seen_by);
  }
  private clear(): void {
    this.layout.clear();
    this.shown = new Set();
    this.names.forEach((name) => (name.is_seen = false));
    this.stage.picture().name_texts.clear();
    this.asked_at = '';
  }

  private inView(): { candidates: LabelCandidate[]; seen_by: Name[] } {
    const picture = this.stage.picture(), { name_texts, cut_view: { shown: cut } } = picture, candidates: LabelCandidate[] = [], seen_by: Name[] = [];
    for (const name of this.names) {
      const at = picture.pointOnScreen(name.point);
      if (!at || at[0] < 0 || at[1] < 0 || at[0] > window.innerWidth || at[1] > window.innerHeight + name.lift_px) continue;
      if (cut && !isKept(cut, name.lattice)) continue;
      seen_by.push(name);
      const size = name_texts.sizeOf(name);
      if (size) candidates.push({ id: name.id, box: name_texts.boxOf(name, size, at), importance: name.importance, depth: at[2], is_seen: name.is_seen });
      if (seen_by.length === kMostCandidates) break;
    }
    return { candidates, seen_by };
  }

  // Again as soon as the eye, what is in view or the cut has changed. What is cut away hides nothing, and the cut's wall does.
  private askSight(terrain: Terrain, now_ms: number, names: readonly Name[]): void {
    const { eye, cut_view: { shown: cut } } = this.stage.picture(), at = `${eye.map((v) => v.toFixed(2)).join()} ${names.map(({ id }) => id).join()}`;
    if (this.is_asking || names.length === 0 || (at === this.asked_at && cut === this.asked_cut) || now_ms - this.asked_ms < kAskEvery_ms || !terrain.isConnected) return;
    [this.is_asking, this.asked_ms, this.asked_at, this.asked_cut] = [true, now_ms, at, cut];
    ++this.asked;
    metExactly(terrain, cut, names.map(({ above }) => ({ from: eye, to: above })))
      .then((met) => met.forEach((each, i) => (names[i]!.is_seen = each === null)), () => (this.asked_at = '')) // asked again with the next frame
      .finally(() => (this.is_asking = false));
  }
}
