// The small readout: where the viewer is, and how smoothly it is drawn. On a click: what a frame costs, what the wire carries, how
// keyframes keep time.
import type { Place, Scene, Statistics } from '@foreland/client';
import { isRemembered, remember } from './remembered';
import { metresText } from './words';

const kWindow_ms = 2000; // over which rates are averaged
const kRefresh_ms = 250;
const kHistory = 60;

export interface Measured {
  now_ms: number;
  statistics: Statistics;
  mesh: { triangles: number; to_nodes: number; tau_px: number } | null;
  strategy: string;
  shown_late_ms: number; // the age of what is shown: t - t_d
  is_late: boolean; // the newer keyframe's time has passed and its successor is not here
  prediction_error_m: number | null; // of the newest keyframe, once its time has come
  scene: Scene | null;
  position: Place | null;
  heading_rad: number;
  eye: readonly number[];
  set_speed_mps: number; // what the keys fly at
}

export class Readout {
  private readonly fields = new Map<string, HTMLElement>();
  private readonly bars: HTMLCanvasElement;
  private readonly where = document.createElement('span');
  private readonly rate = document.createElement('span');
  private readonly history: number[] = [];
  private readonly samples: { at_ms: number; bytes: number; keyframes: number }[] = [];
  private frame_ms = 0;
  private last_frame_ms = 0;
  private last_refresh_ms = 0;
  private last_eye: readonly number[] = [0, 0, 0];

  constructor(private readonly root: HTMLElement) {
    const list = document.createElement('dl');
    for (const name of ['Frame', 'Triangles', 'Stream', 'Keyframes', 'Lateness', 'Error', 'Relief', 'Imagery']) {
      const value = document.createElement('dd');
      list.append(Object.assign(document.createElement('dt'), { textContent: name }), value);
      this.fields.set(name, value);
    }
    this.bars = Object.assign(document.createElement('canvas'), { width: 2 * 180, height: 2 * 26 });
    this.bars.setAttribute('aria-label', 'Kilobytes a second over the last fifteen seconds');
    this.where.className = 'where';
    this.rate.className = 'rate';
    root.append(list, this.bars, this.button());
  }

  // Shows the rest, or only where the viewer is.
  private button(): HTMLElement {
    const button = Object.assign(document.createElement('button'), { type: 'button', title: 'What the stream costs' });
    button.append(this.where, this.rate);
    const open = (is_open: boolean) => {
      this.root.classList.toggle('open', is_open);
      button.setAttribute('aria-expanded', String(is_open));
    };
    button.onclick = () => {
      const is_open = !this.root.classList.contains('open');
      open(is_open);
      remember('readout', is_open);
    };
    open(isRemembered('readout'));
    return button;
  }

  update(m: Measured): void {
    const frame_ms = Math.min(m.now_ms - this.last_frame_ms, 1000);
    this.frame_ms += (frame_ms - this.frame_ms) * 0.08;
    this.last_frame_ms = m.now_ms;
    if (m.now_ms - this.last_refresh_ms < kRefresh_ms) return;
    const speed_mps = Math.hypot(...m.eye.map((v, i) => v - this.last_eye[i]!)) / ((m.now_ms - this.last_refresh_ms) / 1000);
    this.last_refresh_ms = m.now_ms;
    this.last_eye = m.eye;
    this.samples.push({ at_ms: m.now_ms, bytes: m.statistics.bytes_down, keyframes: m.statistics.keyframes });
    while (this.samples.length > 2 && this.samples[0]!.at_ms < m.now_ms - kWindow_ms) this.samples.shift();
    this.showNumbers(m);
    this.showPosition(m, speed_mps);
    this.drawBars();
  }

  // Another session counts from zero.
  forget(): void {
    this.samples.length = 0;
  }

  private showNumbers(m: Measured): void {
    const { statistics: s } = m;
    const rate = this.rates();
    this.rate.textContent = `${(1000 / Math.max(this.frame_ms, 0.1)).toFixed(0)} fps`;
    this.set('Frame', `${this.frame_ms.toFixed(1)} ms`, '');
    this.set('Triangles', (m.mesh?.triangles ?? 0).toLocaleString('en'), `${(m.mesh?.to_nodes ?? 0).toLocaleString('en')} nodes`);
    this.set('Stream', `${bytesText(rate.bytes)}/s`, `${bytesText(s.bytes_down)} in all`);
    this.set('Keyframes', `${rate.keyframes.toFixed(1)} per s`, `${s.late_keyframes} of ${s.keyframes} late`);
    const lateness = s.keyframes === 0 ? '\u2013' : latenessText(s.last_lateness_ms);
    const shown = m.strategy === 'predict' ? '' : `shown ${Math.max(m.shown_late_ms, 0).toFixed(0)} ms ago`;
    this.set('Lateness', lateness, m.is_late ? 'next is late' : shown);
    const bound = m.mesh && Number.isFinite(m.mesh.tau_px) ? `\u2264 ${m.mesh.tau_px.toFixed(2)} px` : 'not known yet';
    this.set('Error', bound, m.prediction_error_m === null ? '' : `eye ${metresText(m.prediction_error_m)} off`);
    const tiles = s.damaged_tiles > 0 ? `${s.damaged_tiles} of ${s.tiles} damaged` : `${s.tiles} tiles`;
    this.showTexels('Relief', s.relief_texel_px, tiles);
    this.showTexels('Imagery', s.imagery_texel_px, isStated(s.relief_texel_px) ? '' : tiles);
    this.history.push(rate.bytes);
    if (this.history.length > kHistory) this.history.shift();
  }

  private rates(): { bytes: number; keyframes: number } {
    const [first, last] = [this.samples[0]!, this.samples[this.samples.length - 1]!];
    const seconds = Math.max(last.at_ms - first.at_ms, kRefresh_ms) / 1000;
    return { bytes: (last.bytes - first.bytes) / seconds, keyframes: (last.keyframes - first.keyframes) / seconds };
  }

  private showPosition(m: Measured, speed_mps: number): void {
    if (!m.position || !m.scene) return;
    const { position } = m;
    const at = 'lat' in position
      ? `${degreesText(position.lat, 'N', 'S')}  ${degreesText(position.lon, 'E', 'W')}`
      : `${position.easting.toFixed(0)} E  ${position.northing.toFixed(0)} N`;
    const above = position.ground === null ? '' : ` \u00b7 ${metresText(position.height - position.ground)} above ground`;
    const slope = position.slope === null ? '' : ` \u00b7 slope ${((position.slope * 180) / Math.PI).toFixed(0)}\u00b0`;
    const heading = ((((m.heading_rad * 180) / Math.PI) % 360) + 360) % 360;
    const lines = [`${at}${slope}`, `${heightsText(position, m.scene.vertical)}${above}`];
    const speed = speed_mps > 1e-3 * m.set_speed_mps ? ` \u00b7 ${metresText(speed_mps)}/s` : '';
    lines.push(`heading ${heading.toFixed(0).padStart(3, '0')}\u00b0${speed}`);
    this.where.replaceChildren(...lines.map((text) => Object.assign(document.createElement('span'), { textContent: text })));
  }

  private drawBars(): void {
    const context = this.bars.getContext('2d')!;
    const { width, height } = this.bars;
    const top = Math.max(...this.history, 1);
    context.clearRect(0, 0, width, height);
    context.fillStyle = 'rgba(126, 178, 230, 0.75)';
    this.history.forEach((bytes, i) => {
      const tall = Math.max(2, (bytes / top) * height);
      context.fillRect((i * width) / kHistory, height - tall, width / kHistory - 2, tall);
    });
  }

  // The largest texel on the screen, if any tile of the layer is drawn.
  private showTexels(name: string, texel_px: number, note: string): void {
    this.setHidden(name, !isStated(texel_px));
    if (isStated(texel_px)) this.set(name, `texels \u2264 ${texel_px.toFixed(1)} px`, note);
  }

  private setHidden(name: string, is_hidden: boolean): void {
    const field = this.fields.get(name)!;
    field.hidden = is_hidden;
    (field.previousElementSibling as HTMLElement).hidden = is_hidden;
  }

  private set(name: string, value: string, note: string): void {
    const field = this.fields.get(name)!;
    const small = Object.assign(document.createElement('small'), { textContent: note });
    field.replaceChildren(value, small);
  }
}

function isStated(texel_px: number): boolean {
  return Number.isFinite(texel_px) && texel_px > 0;
}

function bytesText(bytes: number): string {
  if (bytes < 1000) return `${bytes.toFixed(0)} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(1)} kB`;
  return `${(bytes / 1e6).toFixed(2)} MB`;
}

// By both surfaces, as far as they are known. The one that is not the scene's own may be off, which is said of more than half a metre.
function heightsText(place: Place, vertical: Scene['vertical']): string {
  if (vertical.above === 'unstated') return `${metresText(place.height)} high`;
  const off = vertical.maxError < 0.5 ? '' : ` (\u00b1 ${metresText(vertical.maxError)})`;
  const sea = place.aboveSea === null ? '' : `${metresText(place.aboveSea)} above the sea${vertical.above === 'sea' ? '' : off}`;
  const ellipsoid = place.aboveEllipsoid === null ? '' : `${metresText(place.aboveEllipsoid)} above the ellipsoid${vertical.above === 'ellipsoid' ? '' : off}`;
  return [sea, ellipsoid].filter((text) => text !== '').join(' \u00b7 ');
}

function latenessText(ms: number): string {
  return ms <= 0 ? `${(-ms).toFixed(0)} ms early` : `${ms.toFixed(0)} ms late`;
}

function degreesText(degrees: number, positive: string, negative: string): string {
  return `${Math.abs(degrees).toFixed(5)}\u00b0 ${degrees < 0 ? negative : positive}`;
}
