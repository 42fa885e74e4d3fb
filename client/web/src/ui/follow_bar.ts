// The bar of a flight: its time over a profile of its heights, what its instruments say, and from where and how fast it is seen.
import { clockText, climbText, speedText } from '../follow/instruments';
import type { Journey } from '../follow/journey';
import { durationOf, heightAt, meanClimbAt, meanSpeedAt } from '../follow/flight';
import type { Seat } from '../follow/camera_path';
import { heightText } from '../measure/units';
import { isRemembered } from './remembered';

export type View = Seat | 'free' | 'own';
export const kSpeeds = [1, 2, 5, 10, 20, 50];
const kTitles: Record<View, string> = { chase: 'Chase', cockpit: 'Cockpit', free: 'Free', own: 'Path' };
const kProfile = 300; // places of the profile
const kInstruments_s = 2; // over which they show a mean, of the time in which the flight is shown
const kRefresh_ms = 100;

export interface BarActions {
  play(): void; // or pauses
  seek(time_s: number, is_dragged: boolean): void;
  view(view: View): void;
  speed(speed: number): void;
  close(): void;
}

export interface BarState {
  time_s: number;
  is_playing: boolean;
  view: View;
  speed: number;
}

export class FollowBar {
  private readonly title = document.createElement('strong');
  private readonly play = buttonOf('', 'follow_play', () => this.actions.play());
  private readonly slider = Object.assign(document.createElement('input'), { type: 'range', name: 'follow_time', min: '0', step: 'any', ariaLabel: 'Time of the flight' });
  private readonly profile = document.createElement('div');
  private readonly clock = document.createElement('output');
  private readonly values: Record<'altitude' | 'speed' | 'climb', HTMLElement> = { altitude: document.createElement('dd'), speed: document.createElement('dd'), climb: document.createElement('dd') };
  private readonly view = Object.assign(document.createElement('select'), { name: 'follow_view', ariaLabel: 'From where', title: 'From where it is seen (F)' });
  private readonly speed = Object.assign(document.createElement('select'), { name: 'follow_speed', ariaLabel: 'Play speed', title: 'Play speed (comma and full stop)' });
  private journey: Journey | null = null;
  private is_dragged = false;
  private last_ms = -Infinity;

  constructor(private readonly root: HTMLElement, private readonly actions: BarActions) {
    this.slider.oninput = () => {
      this.is_dragged = true;
      actions.seek(this.slider.valueAsNumber, true);
    };
    this.slider.onchange = () => {
      this.is_dragged = false;
      actions.seek(this.slider.valueAsNumber, false);
    };
    this.view.onchange = () => actions.view(this.view.value as View);
    for (const speed of kSpeeds) this.speed.add(new Option(`${speed}\u00d7`, String(speed)));
    this.speed.onchange = () => actions.speed(Number(this.speed.value));
    const close = buttonOf('\u00d7', 'follow_close', () => actions.close());
    close.ariaLabel = 'End the flight';
    this.profile.className = 'profile_line';
    const header = part('header', this.title, this.view, this.speed, close), line = part('div', this.profile, this.slider);
    line.className = 'line';
    const list = part('dl', ...(['altitude', 'speed', 'climb'] as const).map((name) => part('div', Object.assign(document.createElement('dt'), { textContent: name[0]!.toUpperCase() + name.slice(1) }), this.values[name])));
    const row = part('div', this.play, line, this.clock);
    row.className = 'time_row';
    root.append(header, row, list);
  }

  // Null: there is no flight.
  show(journey: Journey | null): void {
    this.journey = journey;
    this.root.hidden = journey === null;
    document.body.classList.toggle('following', journey !== null);
    if (!journey) return;
    this.title.textContent = this.title.title = journey.name;
    this.slider.max = String(durationOf(journey.flight));
    const views: View[] = journey.seats.length > 0 ? [...journey.seats, 'free'] : ['own', 'free'];
    this.view.replaceChildren(...views.map((view) => new Option(kTitles[view], view)));
    this.profile.replaceChildren(profileOf(journey));
    this.last_ms = -Infinity;
  }

  update(now_ms: number, { time_s, is_playing, view, speed }: BarState): void {
    if (!this.journey || now_ms - this.last_ms < kRefresh_ms) return;
    this.last_ms = now_ms;
    const { flight, begin_ms } = this.journey, units = isRemembered('imperial') ? 'imperial' : 'metric';
    this.play.textContent = is_playing ? '\u275a\u275a' : '\u25b6';
    this.play.ariaLabel = is_playing ? 'Pause the flight' : 'Play the flight';
    this.play.title = `${this.play.ariaLabel} (K)`;
    if (!this.is_dragged) this.slider.value = String(time_s);
    const at = clockText(time_s), all = clockText(durationOf(flight));
    this.slider.ariaValueText = `${at} of ${all}`;
    this.clock.textContent = begin_ms === null ? `${at} / ${all}` : `${new Date(begin_ms + 1000 * time_s).toISOString().slice(11, 19)} UTC`;
    this.clock.title = `${at} of ${all}`;
    this.view.value = view;
    this.speed.value = String(speed);
    this.values.altitude.textContent = heightText(heightAt(flight, time_s), units);
    this.values.speed.textContent = speedText(meanSpeedAt(flight, time_s, kInstruments_s * speed), units);
    this.values.climb.textContent = climbText(meanClimbAt(flight, time_s, kInstruments_s * speed), units);
  }
}

function profileOf({ flight }: Journey): SVGElement {
  const heights = Array.from({ length: kProfile + 1 }, (_, i) => heightAt(flight, (durationOf(flight) * i) / kProfile));
  const [low, high] = [Math.min(...heights), Math.max(...heights)], across = Math.max(high - low, 1);
  const line = heights.map((height, i) => `${i},${(24 - (22 * (height - low)) / across).toFixed(2)}`).join(' ');
  const holder = document.createElement('div');
  holder.innerHTML = `<svg viewBox="0 0 ${kProfile} 26" preserveAspectRatio="none" aria-hidden="true"><polygon points="0,26 ${line} ${kProfile},26"/></svg>`;
  return holder.firstElementChild as SVGElement;
}

function part(tag: string, ...children: HTMLElement[]): HTMLElement {
  const made = document.createElement(tag);
  made.append(...children);
  return made;
}
function buttonOf(text: string, name: string, run: () => void): HTMLButtonElement {
  const button = Object.assign(document.createElement('button'), { type: 'button' as const, name, textContent: text });
  button.onclick = run;
  return button;
}
