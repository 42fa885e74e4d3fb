// The time line of a scene that changes in time: its dates, where scene time is and how fast it goes. Hidden in scenes that do not
// change.
const kDay_ms = 86_400_000;
const kSpeeds = [-90, 10, 30, 90, 365]; // days a second
const kSpeed = 90; // at first

// Sets how scene time goes: from `scene_ms`, since 1970, at `rate` scene seconds a second.
export type SetClock = (scene_ms: number, rate: number) => void;

export class SceneTime {
  private readonly play = document.createElement('button');
  private readonly slider = Object.assign(document.createElement('input'), { type: 'range' });
  private readonly ticks = Object.assign(document.createElement('div'), { className: 'ticks' });
  private readonly date = document.createElement('output');
  private readonly speed = document.createElement('select');
  private epochs_ms: readonly number[] = [];
  private at_ms = 0;
  private is_playing = false;
  private has_left_end = false; // since it began to play
  private is_dragged = false;

  constructor(private readonly root: HTMLElement, private readonly setClock: SetClock) {
    this.play.type = 'button';
    this.play.onclick = () => (this.is_playing ? this.stop() : this.start());
    this.slider.setAttribute('aria-label', 'Time of the scene');
    this.slider.oninput = () => this.drag(Number(this.slider.value));
    this.slider.onchange = () => this.release();
    this.speed.setAttribute('aria-label', 'Speed of the scene time');
    for (const days of kSpeeds) {
      const text = days === 365 ? '1 year/s' : `${days < 0 ? '\u2212' : ''}${Math.abs(days)} days/s`;
      this.speed.append(new Option(text, String(days), days === kSpeed, days === kSpeed));
    }
    this.speed.onchange = () => this.is_playing && this.start();
    const line = Object.assign(document.createElement('div'), { className: 'line' });
    line.append(this.slider, this.ticks);
    root.append(this.play, this.date, line, this.speed);
    this.showPlaying(false);
  }

  // Of the scene that the page shows now; empty if it does not change.
  setEpochs(epochs_ms: readonly number[]): void {
    this.root.hidden = epochs_ms.length < 2;
    this.epochs_ms = epochs_ms;
    if (this.root.hidden) return;
    const [first, last] = [epochs_ms[0]!, epochs_ms[epochs_ms.length - 1]!];
    Object.assign(this.slider, { min: String(first), max: String(last), step: String(Math.min(kDay_ms, (last - first) / 1000)) });
    this.ticks.replaceChildren(...epochs_ms.map((ms) => {
      const tick = document.createElement('i');
      tick.style.left = `${(100 * (ms - first)) / (last - first)}%`;
      tick.title = dateText(ms);
      return tick;
    }));
  }

  // What the last frame shows.
  show(scene_time_ms: number): void {
    if (this.root.hidden || this.is_dragged) return;
    this.at_ms = scene_time_ms;
    this.slider.value = String(scene_time_ms);
    this.date.value = dateText(scene_time_ms);
    if (scene_time_ms !== this.end()) this.has_left_end = true;
    else if (this.is_playing && this.has_left_end) this.showPlaying(false);
  }

  // Where scene time goes to at the chosen speed.
  private end(): number {
    return this.rate() > 0 ? this.epochs_ms[this.epochs_ms.length - 1]! : this.epochs_ms[0]!;
  }
  private rate(): number {
    return Number(this.speed.value) * (kDay_ms / 1000);
  }
  // From the other end if it is at its end.
  private start(): void {
    const others = this.rate() > 0 ? this.epochs_ms[0]! : this.epochs_ms[this.epochs_ms.length - 1]!;
    this.showPlaying(true);
    this.has_left_end = false;
    this.setClock(this.at_ms === this.end() ? others : this.at_ms, this.rate());
  }
  private stop(): void {
    this.showPlaying(false);
    this.setClock(this.at_ms, 0);
  }
  private drag(scene_ms: number): void {
    this.is_dragged = true;
    this.at_ms = scene_ms;
    this.date.value = dateText(scene_ms);
    this.setClock(scene_ms, 0);
  }
  private release(): void {
    this.is_dragged = false;
    if (this.is_playing) this.start();
  }
  private showPlaying(is_playing: boolean): void {
    this.is_playing = is_playing;
    this.play.textContent = is_playing ? '\u275a\u275a' : '\u25b6';
    this.play.setAttribute('aria-label', is_playing ? 'Stop scene time' : 'Run scene time');
  }
}

export function dateText(ms: number): string {
  return new Date(ms).toISOString().slice(0, 10);
}
