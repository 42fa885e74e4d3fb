// What is seen from here, by hand. Shift-click: the first marks where an eye stands, the next draws a line of sight from it, green as
// far as one sees, red beyond. Key V: drapes over the ground what is seen from that eye, or from the camera; again: takes it away.
import type { Sights, Vector } from '../core/sight';
import type { Screen } from '../core/screen';
import type { Welcome } from '../core/values';
import type { Picture } from '../draw/picture';

const kEye_m = 1.7; // above what was clicked
const kLift_m = 0.1; // of what is looked at
const kRadius_m = 10_000;
const kCells = 1000; // across a viewshed, at most
const kClick_px = 4; // a pointer that moves farther drags

// What it needs of the page.
export interface SightStage {
  picture(): Picture;
  screen(): Screen;
  sights(): Sights;
  welcome(): Welcome | null;
  eye(): Vector;
  sceneTime(): number; // ms
  say(text: string): void;
}

export class SightControl {
  private from: Vector | null = null;
  private pressed: [number, number] = [0, 0];
  private asking: AbortController | null = null;
  private is_draped = false;

  constructor(private readonly stage: SightStage) {
    window.addEventListener('pointerdown', (event) => (this.pressed = [event.clientX, event.clientY]));
    window.addEventListener('click', (event) => this.click(event));
    window.addEventListener('keydown', (event) => this.key(event));
  }

  private click(event: MouseEvent): void {
    const moved = Math.hypot(event.clientX - this.pressed[0], event.clientY - this.pressed[1]);
    if (!event.shiftKey || moved > kClick_px || !this.stage.picture().isOn(event.target)) return;
    this.run(() => this.point(event.clientX, event.clientY));
  }
  private key(event: KeyboardEvent): void {
    const is_typing = event.target instanceof HTMLElement && /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName);
    if (event.code !== 'KeyV' || is_typing || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    this.run(() => this.drape());
  }

  private run(work: () => Promise<void>): void {
    work().catch((error: unknown) => {
      if (!(error instanceof DOMException)) this.stage.say(error instanceof Error ? error.message : String(error));
    });
  }

  // Of a point that was clicked.
  async point(x: number, y: number): Promise<void> {
    const point = await this.pick(x, y);
    if (!point) return this.stage.say('There is no ground to see there.');
    const { picture } = this.stage;
    if (!this.from) {
      this.from = point;
      picture().sight_lines.mark(point, picture().up);
      return this.stage.say('Shift-click where to look to, or press V for all that is seen from here.');
    }
    const [sight] = await this.ask(this.above(this.from, kEye_m), this.above(point, kLift_m));
    this.from = null;
    picture().sight_lines.show(sight!);
    this.stage.say(sight!.hit ? `Hidden behind ${sight!.object === null ? 'the ground' : 'an object'}.` : 'Seen.');
  }

  async drape(): Promise<void> {
    const { picture, screen, sights, welcome, say } = this.stage;
    this.asking?.abort();
    this.asking = null;
    if (this.is_draped) {
      this.is_draped = false;
      picture().viewshed.show(null);
      picture().sight_lines.clear();
      this.from = null;
      return;
    }
    const scene = welcome();
    const eye = this.from ?? this.stage.eye();
    const at = screen().mapPosition(eye);
    if (!scene || !at) return;
    const observer_m = this.from || at.ground_m === null ? kEye_m : Math.max(at.height_m - at.ground_m, 0);
    const across_m = Math.hypot(scene.high[0] - scene.low[0], scene.high[1] - scene.low[1]);
    const spacing_m = across_m / Math.hypot(...scene.samples);
    const radius_m = Math.min(kRadius_m, across_m);
    const question = {
      observer: [at.lattice[0], at.lattice[1]] as const, observer_m, radius_m, cell_m: Math.max(spacing_m, (2 * radius_m) / kCells),
      scene_ms: this.stage.sceneTime(),
    };
    this.is_draped = true;
    this.asking = new AbortController();
    say('What is seen from here comes in green.');
    await sights().viewshed(question, (viewshed) => picture().viewshed.show(viewshed), this.asking.signal);
  }

  // The point that a pixel shows, exactly: what the straight line through it meets first.
  private async pick(x: number, y: number): Promise<Vector | null> {
    const scene = this.stage.welcome();
    if (!scene) return null;
    const eye = this.stage.eye();
    const far_m = 2 * Math.hypot(scene.high[0] - scene.low[0], scene.high[1] - scene.low[1]);
    const way = this.stage.picture().directionAt(x, y);
    const there: Vector = [eye[0] + far_m * way[0], eye[1] + far_m * way[1], eye[2] + far_m * way[2]];
    const straight = scene.is_geographic ? 0 : 1;
    const [sight] = await this.ask(this.above(eye, 0), this.above(there, 0), straight);
    return sight!.hit;
  }

  private above(point: Vector, metres: number): readonly [number, number, number] {
    const at = this.stage.screen().mapPosition(point)!;
    return [at.lattice[0], at.lattice[1], at.height_m + metres];
  }

  private ask(from: readonly [number, number, number], to: readonly [number, number, number], refraction?: number) {
    const question = { pairs: [[from, to] as const], above: 'zero surface' as const, scene_ms: this.stage.sceneTime() };
    return this.stage.sights().visible(refraction === undefined ? question : { ...question, refraction });
  }
}
