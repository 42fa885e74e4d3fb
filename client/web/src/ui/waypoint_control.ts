// Waypoints by hand: P adds where the camera is, Backspace takes the last one back. The camera then flies a smooth way through them, which can
// be kept as a file.
import { journeyThrough, tourOf, waypointsOf } from '../follow/journey';
import { tourIn, tourJson, tourKml, type Waypoint } from '../follow/waypoints';
import { lengthText } from '../measure/units';
import type { Controls } from './controls';
import type { FollowControl } from './follow_control';
import { said } from './language';
import { isRemembered } from './remembered';
import { saveFile } from './save_file';
import { isForPage, type Stage } from './stage';

const kName = 'Path', kLeg_s = 6; // at first
const kShortest_s = 2, kLongest_s = 600;

export class WaypointControl {
  private waypoints: Waypoint[] = [];
  private seconds: number | null = null; // as a person has set it
  private is_open = false;
  private readonly help = Object.assign(document.createElement('p'), { className: 'help' });
  private readonly length = document.createElement('output');
  private readonly slider = Object.assign(document.createElement('input'), { type: 'range', name: 'path_seconds', min: '0', max: '1', step: 'any', ariaLabel: 'Seconds of the path' });
  private readonly buttons: Record<'add' | 'play' | 'json' | 'kml' | 'clear', HTMLButtonElement>;
  private readonly button: HTMLButtonElement;

  constructor(tools: HTMLElement, private readonly card: HTMLElement, private readonly stage: Stage, private readonly controls: Controls, private readonly follow: FollowControl) {
    this.button = buttonOf('Path', 'path', () => this.open(!this.is_open));
    this.button.title = 'A path of the camera through waypoints (P adds one)';
    this.button.setAttribute('aria-pressed', 'false');
    tools.append(this.button);
    this.buttons = {
      add: buttonOf('Add', 'path_add', () => this.add()), play: buttonOf('Fly', 'path_play', () => this.play()), json: buttonOf('JSON', 'path_json', () => this.save('json')),
      kml: buttonOf('KML', 'path_kml', () => this.save('kml')), clear: buttonOf('Clear', 'path_clear', () => this.change([])),
    };
    const header = document.createElement('header'), footer = document.createElement('footer'), row = document.createElement('div');
    const close = buttonOf('\u00d7', 'path_close', () => this.open(false));
    close.ariaLabel = 'Close the path';
    header.append(Object.assign(document.createElement('strong'), { textContent: 'Path' }), close);
    row.className = 'row slider';
    row.append(Object.assign(document.createElement('span'), { textContent: 'Time' }), this.length, this.slider);
    this.slider.oninput = () => {
      this.seconds = Math.round(kShortest_s * (kLongest_s / kShortest_s) ** this.slider.valueAsNumber);
      this.show();
    };
    footer.append(...Object.values(this.buttons));
    card.append(header, this.help, row, footer);
    window.addEventListener('keydown', (event) => this.key(event));
  }

  // For tests.
  status(): Record<string, unknown> {
    return { waypoints: this.waypoints.length };
  }

  // A file of a tour; false: it is none. An Error says what is wrong with it.
  take(json: unknown): boolean {
    const found = tourIn(json), terrain = this.stage.terrain();
    if (!found || !terrain?.hasScene) return false;
    if (('lat' in found.waypoints[0]!.place) !== (terrain.scene.frame !== 'planar')) throw new Error('The tour is of another map than the scene.');
    this.seconds = found.seconds;
    this.open(true);
    this.change(waypointsOf(terrain, found.waypoints));
    this.play();
    return true;
  }

  private open(is_open: boolean): void {
    this.is_open = is_open;
    this.card.hidden = !is_open;
    this.button.setAttribute('aria-pressed', String(is_open));
    this.show();
  }

  private add(): void {
    const terrain = this.stage.terrain(), { eye, look } = this.controls;
    const place = terrain?.hasScene ? terrain.place(eye.toArray()) : null;
    if (!place) return;
    if (!this.is_open) this.open(true);
    this.change([...this.waypoints, { eye: eye.toArray(), height_m: place.height, heading: look.heading, pitch: look.pitch }]);
  }
  private change(waypoints: Waypoint[]): void {
    this.waypoints = waypoints;
    if (waypoints.length === 0) this.seconds = null;
    this.show();
  }
  private get duration_s(): number {
    return this.seconds ?? Math.min(Math.max(kLeg_s * (this.waypoints.length - 1), kShortest_s), kLongest_s);
  }

  private show(): void {
    const count = this.waypoints.length, units = isRemembered('imperial') ? 'imperial' : 'metric';
    const way_m = this.waypoints.slice(1).reduce((sum, { eye }, i) => sum + Math.hypot(...eye.map((v, k) => v - this.waypoints[i]!.eye[k]!)), 0);
    this.help.textContent = count === 0 ? 'Fly to where the path begins, and press P to add a waypoint.'
      : count === 1 ? 'One waypoint. Fly on, and press P to add the next one.' : `${count} waypoints, ${lengthText(way_m, units)}. Backspace takes the last one back.`;
    this.length.textContent = this.slider.ariaValueText = `${this.duration_s} s`;
    this.slider.value = String(Math.log(this.duration_s / kShortest_s) / Math.log(kLongest_s / kShortest_s));
    this.buttons.play.disabled = this.buttons.json.disabled = this.buttons.kml.disabled = count < 2;
    this.buttons.kml.hidden = this.stage.terrain()?.hasScene === true && this.stage.terrain()!.scene.frame === 'planar';
    this.buttons.clear.disabled = count === 0;
  }

  private play(): void {
    const terrain = this.stage.terrain();
    if (terrain?.hasScene && this.waypoints.length > 1) this.follow.begin(journeyThrough(terrain, kName, this.waypoints, this.duration_s));
  }
  private save(kind: 'json' | 'kml'): void {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene) return;
    const { tour, times_s } = tourOf(terrain, kName, this.waypoints, this.duration_s);
    if (kind === 'json') saveFile(new Blob([tourJson(tour)], { type: 'application/geo+json' }), 'path.json');
    else saveFile(new Blob([tourKml(tour, times_s)], { type: 'application/vnd.google-earth.kml+xml' }), 'path.kml');
  }

  private key(event: KeyboardEvent): void {
    if (event.repeat || !isForPage(event)) return;
    if (event.code === 'KeyP') this.add();
    if (this.is_open && event.code === 'Backspace' && !document.body.classList.contains('measuring')) this.change(this.waypoints.slice(0, -1));
  }
}

function buttonOf(text: string, name: string, run: () => void): HTMLButtonElement {
  const button = Object.assign(document.createElement('button'), { type: 'button' as const, name, textContent: said(text) });
  button.onclick = run;
  return button;
}
