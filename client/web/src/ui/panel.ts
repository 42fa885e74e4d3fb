// The settings panel. It changes the Settings that it is given and calls onChange.
import { kBlends, kPredictors, kStrategies } from '@foreland/client';
import { kGrounds } from '@foreland/client/three';
import { adapts, mayAdapt, type Settings } from './settings';
import { kSunModes } from './sun';

const kNames: Record<string, string> = {
  delay: 'Delay', current: 'Current', predict: 'Predict', keyframe: 'Keyframes', geomorph: 'Geomorphs', 'b-spline-2': 'Spline 2', 'b-spline-3': 'Spline 3',
  auto: 'Automatic', hold: 'Hold', velocity: 'Constant velocity', acceleration: 'Constant acceleration', path: 'Known path',
  natural: 'Natural', plain: 'Plain', slope: 'Slope', aspect: 'Aspect', heights: 'Heights', change: 'Change in time', map: 'As on maps', clock: 'Date and time', free: 'Free',
};
const kHelp: Record<string, string> = {
  delay: 'Geometry and camera are shown one keyframe late.',
  current: 'The camera is current, the geometry one keyframe late.',
  predict: 'Keyframes are computed ahead, for the predicted camera.',
  keyframe: 'All detail blends from one keyframe to the next.',
  geomorph: 'Each vertex blends by its own timing, within a second.',
  'b-spline-2': 'Detail follows a spline of three keyframes, at no abrupt speed.',
  'b-spline-3': 'The same of four keyframes: smoother, and further ahead.',
};

const kLegends: Record<string, string[]> = {
  slope: ['0\u00b0', '10', '20', '30', '40', '50\u00b0'],
  aspect: ['N', 'E', 'S', 'W', 'N'],
};

type NumberKey = 'tau_px' | 'keyframe_ms' | 'snow_line' | 'change' | 'sun_day' | 'sun_hour' | 'sun_azimuth_deg' | 'sun_height_deg';

function dayText(day: number): string {
  return new Date(Date.UTC(2001, 0, day)).toLocaleDateString('en', { day: 'numeric', month: 'short', timeZone: 'UTC' });
}
function hourText(hour: number): string {
  return `${Math.floor(hour).toString().padStart(2, '0')}:${Math.round(60 * (hour % 1)).toString().padStart(2, '0')}`;
}

// Heights to two or three digits.
function metresText(metres: number): string {
  return metres.toFixed(metres < 1 ? 2 : metres < 10 ? 1 : 0);
}
function changeWords(max_m: number): string[] {
  const half = metresText(max_m / 2);
  return [`\u2212${metresText(max_m)} m`, `\u2212${half}`, '0', `+${half}`, `+${metresText(max_m)} m`];
}

export class Panel {
  private readonly help = { strategy: element('p', 'help'), blend: element('p', 'help') };
  private readonly body = element('div', 'body');
  private rows: HTMLElement = this.body; // to which the next row is added
  private readonly legend = element('div', 'legend');
  private readonly sun_rows: Record<'clock' | 'free', HTMLElement[]> = { clock: [], free: [] };
  private readonly texts: (() => void)[] = []; // that write what sliders stand at
  private readonly selects: { select: HTMLSelectElement; key: 'predictor' | 'ground' | 'sun' }[] = [];
  private readonly colours = document.createElement('select');
  private readonly colour_rows: HTMLElement[] = [];
  private heights_legend: { gradient: string; words: string[] } = { gradient: '', words: [] };
  private heights: [number, number] | null = null;
  private max_moved_m = 0;
  private change_row!: HTMLElement;
  private adaptive_row!: HTMLElement;
  private is_geographic = true;

  // `colours` are the names of colour maps; `file` is where another one is opened.
  constructor(root: HTMLElement, private readonly settings: Settings, colours: readonly string[], private readonly file: HTMLInputElement,
              private readonly onChange: () => void) {
    const toggle = element('button', 'toggle') as HTMLButtonElement;
    toggle.type = 'button';
    toggle.innerHTML = '<span>Settings</span><svg viewBox="0 0 16 16" aria-hidden="true"><path d="M4 6l4 4 4-4"/></svg>';
    const fold = (is_open: boolean) => {
      root.classList.toggle('open', is_open);
      toggle.setAttribute('aria-expanded', String(is_open));
    };
    toggle.onclick = () => fold(!root.classList.contains('open'));
    root.append(toggle, this.body);
    fold(window.matchMedia('(min-width: 700px) and (min-height: 520px)').matches);
    this.addControls();
    for (const name of colours) this.addColours(name);
    this.changed();
  }

  // A button below the rest.
  addButton(title: string, name: string, run: () => void): void {
    const button = Object.assign(document.createElement('button'), { type: 'button', name, textContent: title });
    button.onclick = run;
    const row = element('div', 'row');
    row.append(button);
    this.body.append(row);
  }
  // Another colour map, which can be chosen from now on.
  addColours(name: string): void {
    if ([...this.colours.options].every((option) => option.value !== name)) this.colours.add(new Option(titleOf(name), name));
    this.colours.value = this.settings.colours;
  }
  // What is chosen, after it has been changed elsewhere.
  showChoices(): void {
    for (const { select, key } of this.selects) select.value = this.settings[key];
    this.showRows();
  }
  // Of the colour map that is chosen.
  setHeightsLegend(legend: { gradient: string; words: string[] }): void {
    this.heights_legend = legend;
    this.showRows();
  }

  private addControls(): void {
    this.addChoice('Strategy', 'strategy', kStrategies);
    this.addChoice('Blend', 'blend', kBlends);
    this.addSelect('Predictor', 'predictor', ['auto', ...kPredictors]);
    this.addSlider('Tolerance', 'tau_px', [-2, 4, 0.25], (v) => 2 ** v, Math.log2, (v) => `${v.toFixed(v < 1 ? 2 : 1)} px`);
    this.addSlider('Keyframes every', 'keyframe_ms', [2, 20, 1], (v) => 50 * v, (v) => v / 50, (v) => (adapts(this.settings) ? 'adaptive' : `${v} ms`));
    this.adaptive_row = this.addSwitch('Adaptive keyframes', 'adaptive');
    this.addSwitch('Wireframe', 'wireframe');
    this.addSwitch('Relief shading', 'relief');
    this.addSwitch('Cast shadows', 'shadows');
    this.addSwitch('Imagery', 'imagery');
    this.addSwitch('Contours', 'contours');
    this.addSwitch('Haze', 'fog');
    this.addSwitch('Occlusion culling', 'occlusion');
    this.addSwitch('Freeze section', 'frozen');
    this.addLook();
  }

  // In a part of its own, which is folded until it is wanted.
  private addLook(): void {
    const look = document.createElement('details');
    look.append(Object.assign(element('summary'), { textContent: 'Light and colours' }));
    look.open = this.settings.sun !== 'map' || this.settings.ground !== 'natural';
    this.body.append(look);
    this.rows = look;
    const same = (v: number) => v;
    this.addSelect('Ground', 'ground', kGrounds);
    look.append(this.legend);
    this.addColourRows();
    this.addSlider('Snow line', 'snow_line', [0, 1.1, 0.01], same, same, (v) => this.heightText(v));
    this.change_row = this.addSlider('Strongest colours', 'change', [-6, 0, 0.5], (v) => 2 ** v, Math.log2, (v) => `\u00b1 ${metresText(v * this.max_moved_m)} m`);
    this.addSelect('Sun', 'sun', kSunModes);
    this.sun_rows.clock.push(this.addSlider('Day', 'sun_day', [1, 365, 1], same, same, dayText));
    this.sun_rows.clock.push(this.addSlider('Hour', 'sun_hour', [0, 24, 0.25], same, same, hourText));
    this.sun_rows.free.push(this.addSlider('Azimuth', 'sun_azimuth_deg', [0, 360, 1], same, same, (v) => `${v.toFixed(0)}\u00b0`));
    this.sun_rows.free.push(this.addSlider('Height', 'sun_height_deg', [0, 90, 1], same, same, (v) => `${v.toFixed(0)}\u00b0`));
  }

  private addColourRows(): void {
    this.colours.name = 'colours';
    this.colours.onchange = () => {
      this.settings.colours = this.colours.value;
      this.changed();
    };
    Object.assign(this.file, { type: 'file', accept: '.cpt', name: 'colour_file' });
    this.colour_rows.push(this.addRow('Colours', this.colours), this.addRow('Open a .cpt file', this.file));
  }

  // The scene's lowest and highest ground, by how much it changes in time, and whether it is on the earth.
  setScene(lowest_m: number, highest_m: number, max_moved_m: number, is_geographic: boolean): void {
    [this.heights, this.max_moved_m, this.is_geographic] = [[lowest_m, highest_m], max_moved_m, is_geographic];
    this.body.querySelector<HTMLOptionElement>('option[value=change]')!.hidden = max_moved_m === 0;
    for (const show of this.texts) show();
    this.showRows();
  }

  private heightText(share: number): string {
    if (!this.heights) return `${(100 * share).toFixed(0)} %`;
    const [low, high] = this.heights;
    return share > 1.05 ? 'none' : `${(low + share * (high - low)).toFixed(0)} m`;
  }

  private showRows(): void {
    const { sun, ground } = this.settings;
    this.adaptive_row.hidden = !mayAdapt(this.settings);
    const is_clock = sun === 'clock' && this.is_geographic;
    for (const row of this.sun_rows.clock) row.hidden = !is_clock;
    for (const row of this.sun_rows.free) row.hidden = sun === 'map' || is_clock;
    this.legend.className = `legend ${ground}`;
    for (const row of this.colour_rows) row.hidden = ground !== 'heights';
    const tells_change = ground === 'change' && this.max_moved_m > 0;
    this.change_row.hidden = !tells_change;
    const ramp_words = ground === 'heights' ? this.heights_legend.words : kLegends[ground] ?? [];
    const words = tells_change ? changeWords(this.settings.change * this.max_moved_m) : ramp_words;
    this.legend.style.backgroundImage = ground === 'heights' ? this.heights_legend.gradient : '';
    this.legend.replaceChildren(...words.map((text) => Object.assign(element('span'), { textContent: text })));
    this.legend.hidden = words.length === 0;
  }

  private changed(): void {
    for (const show of this.texts) show();
    this.showRows();
    for (const key of ['strategy', 'blend'] as const) this.help[key].textContent = kHelp[this.settings[key]] ?? '';
    this.onChange();
  }

  private addChoice<Key extends 'strategy' | 'blend'>(title: string, key: Key, values: readonly Settings[Key][]): void {
    const group = element('div', 'choice');
    group.setAttribute('role', 'radiogroup');
    group.setAttribute('aria-label', title);
    for (const value of values) {
      const label = element('label');
      const input = Object.assign(document.createElement('input'), { type: 'radio', name: key, value });
      input.checked = this.settings[key] === value;
      input.onchange = () => {
        this.settings[key] = value;
        this.changed();
      };
      label.append(input, Object.assign(element('span'), { textContent: kNames[value] }));
      group.append(label);
    }
    this.body.append(group, this.help[key]);
  }

  private addSelect(title: string, key: 'predictor' | 'ground' | 'sun', values: readonly string[]): void {
    const select = Object.assign(document.createElement('select'), { name: key });
    for (const value of values) select.add(new Option(kNames[value], value));
    select.value = this.settings[key];
    select.onchange = () => {
      (this.settings[key] as string) = select.value;
      this.changed();
    };
    this.selects.push({ select, key });
    this.addRow(title, select);
  }

  private addSlider(title: string, key: NumberKey, [min, max, step]: readonly [number, number, number], toValue: (v: number) => number,
                    toSlider: (v: number) => number, text: (v: number) => string): HTMLElement {
    const slider = Object.assign(document.createElement('input'), { type: 'range', name: key });
    Object.assign(slider, { min: String(min), max: String(max), step: String(step) });
    slider.value = String(toSlider(this.settings[key]));
    const output = element('output');
    const show = () => (output.textContent = text(this.settings[key]));
    slider.oninput = () => {
      this.settings[key] = toValue(slider.valueAsNumber);
      show();
      this.changed();
    };
    show();
    const row = this.addRow(title, output);
    row.classList.add('slider');
    row.append(slider);
    this.texts.push(show);
    return row;
  }

  private addSwitch(title: string, key: 'adaptive' | 'wireframe' | 'relief' | 'shadows' | 'imagery' | 'contours' | 'fog' | 'occlusion' | 'frozen'): HTMLElement {
    const input = Object.assign(document.createElement('input'), { type: 'checkbox', name: key });
    input.checked = this.settings[key];
    input.onchange = () => {
      this.settings[key] = input.checked;
      this.changed();
    };
    const row = this.addRow(title, input);
    row.classList.add('switch');
    return row;
  }

  private addRow(title: string, control: HTMLElement): HTMLElement {
    const row = element('label', 'row');
    row.append(Object.assign(element('span'), { textContent: title }), control);
    this.rows.append(row);
    return row;
  }
}

function element(tag: string, name = ''): HTMLElement {
  const made = document.createElement(tag);
  made.className = name;
  return made;
}

function titleOf(name: string): string {
  return name.charAt(0).toUpperCase() + name.slice(1);
}
