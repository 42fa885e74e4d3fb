// Recording by hand: a picture of what is seen, larger than the window, or a flight as a video or as pictures, frame by frame. Each frame is
// waited for until it is exact, however long that takes; the page draws nothing else meanwhile.
import type { Pose } from '@foreland/client';
import { ExactFrames } from '../draw/exact_frames';
import { durationOf } from '../follow/flight';
import { poseOn } from '../follow/camera_path';
import { clockText } from '../follow/instruments';
import { sizeWithin, timeLeft_s, timesOf, type Container, type Take } from '../record/frames';
import { canEncode, pngOf, sinkOf, type FrameSink } from '../record/sinks';
import type { FollowControl } from './follow_control';
import { boundTo, element, Form } from './form';
import { said } from './language';
import { saveFile } from './save_file';
import type { Stage } from './stage';
import { reasonOf } from './words';

const kSizes = ['1280x720', '1920x1080', '2560x1440', '3840x2160', '1080x1920', '640x360'] as const;
const kRates = ['10', '24', '25', '30', '50', '60'] as const;
const kLargest = 16384; // of a side, in pixels

// What it needs of the page beside the stage.
export interface RecordStage extends Stage {
  pose(): Pose; // of the camera
  beginFrames(): void; // the page draws no more, and asks for views that rest
  endFrames(): void;
}

export class RecordControl {
  private readonly choice = { factor: '2', size: '1280x720' as (typeof kSizes)[number], rate: '30' as (typeof kRates)[number], container: (canEncode() ? 'mp4' : 'png') as Container, seconds: 10 };
  private readonly form = new Form(() => this.show());
  private readonly help = Object.assign(document.createElement('p'), { className: 'help' });
  private readonly buttons: Record<'picture' | 'video' | 'cancel', HTMLButtonElement>;
  private readonly progress = Object.assign(document.createElement('progress'), { ariaLabel: 'Progress of the recording' });
  private readonly said = document.createElement('output');
  private readonly settings = element('div', 'rows');
  private readonly running = element('div', 'rows');
  private readonly button: HTMLButtonElement;
  private is_open = false;
  private abort: AbortController | null = null; // of what is recorded now
  private done = 0; // frames of it

  constructor(tools: HTMLElement, private readonly card: HTMLElement, private readonly stage: RecordStage, private readonly follow: FollowControl) {
    this.button = buttonOf('Record', 'record_card', () => this.open(!this.is_open));
    this.button.title = 'A large picture, or a flight as a video';
    this.button.setAttribute('aria-pressed', 'false');
    tools.append(this.button);
    this.buttons = { picture: buttonOf('Save a picture', 'save_picture', () => void this.savePicture()), video: buttonOf('Record the flight', 'save_video', () => void this.saveVideo()),
      cancel: buttonOf('Cancel', 'cancel_recording', () => this.abort?.abort()) };
    const header = document.createElement('header'), close = buttonOf('\u00d7', 'record_close', () => this.open(false));
    close.ariaLabel = 'Close recording';
    header.append(Object.assign(document.createElement('strong'), { textContent: 'Record' }), close);
    this.fill();
    this.running.append(this.progress, this.said, this.buttons.cancel);
    card.append(header, this.settings, this.running);
    this.show();
  }

  // For tests.
  status(): Record<string, unknown> {
    return { recording: this.abort !== null, recorded_frames: this.done };
  }
  get isOn(): boolean {
    return this.abort !== null;
  }
  // What it draws on is gone.
  cancel(reason: string): void {
    this.abort?.abort(new Error(reason));
  }

  private fill(): void {
    const { form, settings, choice } = this;
    form.select(settings, 'Picture', 'picture_factor', ['1', '2', '4'], ['As the window', '2 \u00d7 the window', '4 \u00d7 the window'], boundTo(choice, 'factor'));
    settings.append(this.buttons.picture);
    form.select(settings, 'Video', 'video_size', kSizes, kSizes.map((size) => size.replace('x', ' \u00d7 ')), boundTo(choice, 'size'));
    form.select(settings, 'Frames a second', 'video_rate', kRates, kRates, boundTo(choice, 'rate'));
    form.select(settings, 'Format', 'video_format', canEncode() ? ['mp4', 'webm', 'png'] : ['png'], canEncode() ? ['MP4', 'WebM', 'Pictures (PNG)'] : ['Pictures (PNG)'], boundTo(choice, 'container'));
    form.slider(settings, 'Seconds', 'video_seconds', boundTo(choice, 'seconds'), { range: [0, 1, 0.001], text: (seconds) => `${seconds} s`,
      toValue: (position) => Math.max(1, Math.round(300 ** position)), toPosition: (seconds) => Math.log(seconds) / Math.log(300) });
    settings.append(this.help, this.buttons.video);
  }

  private open(is_open: boolean): void {
    if (this.abort) return;
    this.is_open = is_open;
    this.card.hidden = !is_open;
    this.button.setAttribute('aria-pressed', String(is_open));
    this.show();
  }

  private show(): void {
    const { followed } = this.follow, is_on = this.abort !== null;
    this.settings.hidden = is_on;
    this.running.hidden = !is_on;
    this.buttons.video.disabled = followed === null;
    this.help.textContent = followed === null ? 'Drop a track on the page, or make a path, to record a flight along it.'
      : `From where the flight is now, as it is seen: ${this.framesOf(this.take()!).length.toLocaleString('en')} frames, each within the tolerance.`;
    document.body.classList.toggle('recording', is_on);
  }
  // When a flight begins or ends elsewhere.
  refresh(): void {
    if (this.is_open && !this.abort) this.show();
  }

  private take(): Take | null {
    const { followed } = this.follow, { size, rate, container, seconds } = this.choice;
    if (!followed) return null;
    const [width, height] = size.split('x').map(Number) as [number, number];
    const left_s = durationOf(followed.journey.flight) - followed.time_s, from_s = left_s > 0 ? followed.time_s : 0;
    return { width, height, rate: Number(rate), container, from_s, speed: followed.speed, seconds: Math.min(seconds, (durationOf(followed.journey.flight) - from_s) / followed.speed) };
  }
  private framesOf(take: Take): number[] {
    return timesOf(take);
  }

  private async savePicture(): Promise<void> {
    const { width, height } = this.stage.picture().renderer.domElement, factor = Number(this.choice.factor);
    const pose = this.stage.pose();
    await this.run(1, sizeWithin(width * factor, height * factor, kLargest), async (frames, signal) => {
      const picture = await frames.draw(pose, null, signal, ({ canvas }) => pngOf(canvas));
      saveFile(picture, 'foreland.png');
      return 'The picture is saved.';
    });
  }

  private async saveVideo(): Promise<void> {
    const { followed } = this.follow, take = this.take();
    if (!followed || !take) return;
    const times = this.framesOf(take), terrain = this.stage.terrain()!;
    const poses = times.map((time_s) => poseOn(followed.path, time_s));
    this.follow.pause();
    await this.run(times.length, [take.width, take.height], async (frames, signal) => {
      let sink: FrameSink | null = null, worst_px = 0;
      try {
        sink = await sinkOf(take, times.length);
        for (const [i, time_s] of times.entries()) {
          this.follow.mark(terrain, time_s);
          await frames.draw(poses[i]!, poses[i + 1] ?? null, signal, ({ canvas, guaranteed_px }) => {
            worst_px = Math.max(worst_px, guaranteed_px);
            return sink!.add(canvas, i);
          });
          this.tell(i + 1, times.length);
        }
        const { file, name } = await sink.finish();
        saveFile(file, name);
        return `${name} is saved: ${times.length.toLocaleString('en')} frames, none more than ${worst_px.toFixed(2)} px off.`;
      } catch (error) {
        await sink?.cancel();
        throw error;
      }
    });
  }

  private begin_ms = 0;
  private async run(count: number, [width, height]: [number, number], work: (frames: ExactFrames, signal: AbortSignal) => Promise<string>): Promise<void> {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene || this.abort) return;
    if (this.stage.picture().headset.isOn) return this.stage.say('A headset shows the scene: leave it to record.');
    const abort = (this.abort = new AbortController());
    this.begin_ms = performance.now();
    this.tell(0, count);
    this.show();
    const frames = new ExactFrames(this.stage.picture(), terrain);
    let words = '';
    try {
      frames.resize(width, height);
      this.stage.beginFrames(); // what is asked for depends on the size
      words = await work(frames, abort.signal);
    } catch (error) {
      words = abort.signal.aborted && !(abort.signal.reason instanceof Error && abort.signal.reason.name === 'Error') ? 'The recording is cancelled.' : `Nothing is recorded: ${reasonOf(error)}`;
    }
    frames.end();
    this.abort = null;
    this.stage.endFrames();
    this.show();
    this.stage.say(words);
  }
  private tell(done: number, count: number): void {
    this.done = done;
    this.progress.max = count;
    this.progress.value = done;
    const left_s = timeLeft_s(done, count, (performance.now() - this.begin_ms) / 1000);
    this.said.textContent = count === 1 ? 'Waiting for the exact view\u2026' : `Frame ${Math.min(done + 1, count).toLocaleString('en')} of ${count.toLocaleString('en')}${left_s === null ? '' : ` \u00b7 ${clockText(left_s)} left`}. Keep this tab in view.`;
  }
}

function buttonOf(text: string, name: string, run: () => void): HTMLButtonElement {
  const button = Object.assign(document.createElement('button'), { type: 'button' as const, name, textContent: said(text) });
  button.onclick = run;
  return button;
}
