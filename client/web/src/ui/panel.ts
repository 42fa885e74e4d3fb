// The settings panel. What a visitor wants is in view; how the stream works is in a fold, the laboratory. It changes the Settings that it
// is given and calls onChange.
import type { Scene } from '@foreland/client';
import { kBlends, kPredictors, kStrategies } from '@foreland/client';
import { kGrounds } from '@foreland/client/three';
import { kExaggerations } from '../draw/exaggeration';
import { boundTo, element, Form, type Bound } from './form';
import { said } from './language';
import { isRemembered, remember } from './remembered';
import { adapts, mayAdapt, type Settings } from './settings';
import { kSunModes } from './sun';
import { metresText } from './words';

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

function dayText(day: number): string {
  return new Date(Date.UTC(2001, 0, day)).toLocaleDateString('en', { day: 'numeric', month: 'short', timeZone: 'UTC' });
}
function hourText(hour: number): string {
  return `${Math.floor(hour).toString().padStart(2, '0')}:${Math.round(60 * (hour % 1)).toString().padStart(2, '0')}`;
}
function degreesText(degrees: number): string {
  return `${degrees.toFixed(0)}\u00b0`;
}
function pixelsText(px: number): string {
  return `${px.toFixed(px < 1 ? 2 : 1)} px`;
}
function qualityText(tau_px: number): string {
  const words = ['Finest', 'Fine', 'Good', 'Fast', 'Fastest'];
  return said(words[Math.min(Math.max(Math.round(Math.log2(tau_px)) + 2, 0), 4)]!);
}

// Heights to two or three digits.
function changeText(metres: number): string {
  return metres.toFixed(metres < 1 ? 2 : metres < 10 ? 1 : 0);
}
function changeWords(max_m: number): string[] {
  const half = changeText(max_m / 2);
  return [`\u2212${changeText(max_m)} m`, `\u2212${half}`, '0', `+${half}`, `+${changeText(max_m)} m`];
}

export class Panel {
  private readonly form: Form;
  private readonly help = { strategy: element('p', 'help'), blend: element('p', 'help') };
  private readonly body = element('div', 'body');
  private readonly laboratory = foldOf('Laboratory', 'laboratory');
  private readonly legend = element('div', 'legend');
  private readonly sun_rows: Record<'clock' | 'free', HTMLElement[]> = { clock: [], free: [] };
  private readonly colours = document.createElement('select');
  private readonly flat_rows: HTMLElement[] = []; // of what there is not on globes
  private readonly colour_rows: HTMLElement[] = [];
  private readonly layer_rows: Partial<Record<'relief' | 'shadows' | 'imagery', HTMLElement>> = {};
  private heights_legend: { gradient: string; words: string[] } = { gradient: '', words: [] };
  private scene: Scene | null = null;
  private ground_select!: HTMLSelectElement;
  private snow_row!: HTMLElement;
  private change_row!: HTMLElement;
  private adaptive_row!: HTMLElement;
  private sea_row!: HTMLElement;

  // `colours` are the names of colour maps; `file` is where another one is opened; `speed_mps` is how fast the keys fly.
  constructor(root: HTMLElement, private readonly settings: Settings, colours: readonly string[], private readonly file: HTMLInputElement,
              speed_mps: Bound<number>, private readonly onChange: () => void) {
    this.form = new Form(() => this.changed());
    root.append(toggleOf(root), this.body);
    this.addColourControls();
    this.addLight();
    this.addLayers();
    this.addOverlays();
    this.addFlight(speed_mps);
    this.body.append(this.laboratory);
    this.addLaboratory();
    for (const name of colours) this.addColours(name);
    this.changed();
  }

  // A button at the end of the laboratory.
  addButton(title: string, name: string, run: () => void): void {
    const button = Object.assign(document.createElement('button'), { type: 'button', name, textContent: title });
    button.onclick = run;
    const row = element('div', 'row');
    row.append(button);
    this.laboratory.append(row);
  }
  // Another colour map, which can be chosen from now on.
  addColours(name: string): void {
    if ([...this.colours.options].every((option) => option.value !== name)) this.colours.add(new Option(titleOf(name), name));
    this.colours.value = this.settings.colours;
  }
  // What is chosen, after it has been changed elsewhere.
  showChoices(): void {
    this.form.show();
    this.showRows();
  }
  // Of the colour map that is chosen.
  setHeightsLegend(legend: { gradient: string; words: string[] }): void {
    this.heights_legend = legend;
    this.showRows();
  }
  setScene(scene: Scene): void {
    this.scene = scene;
    this.ground_select.querySelector<HTMLOptionElement>('option[value=change]')!.hidden = scene.maxMoved === 0;
    this.showChoices();
  }

  // Whether the scene has a sea that can be left out.
  setSea(exists: boolean): void {
    this.sea_row.hidden = !exists;
  }

  private addColourControls(): void {
    const { form, body, settings } = this;
    this.ground_select = form.select(body, 'Ground', 'ground', kGrounds, namesOf(kGrounds), boundTo(settings, 'ground'));
    body.append(this.legend);
    this.colours.name = 'colours';
    this.colours.onchange = () => {
      settings.colours = this.colours.value;
      this.changed();
    };
    Object.assign(this.file, { type: 'file', accept: '.cpt', name: 'colour_file' });
    this.colour_rows.push(form.row(body, 'Colours', this.colours), form.row(body, 'Open a .cpt file', this.file));
    this.snow_row = form.slider(body, 'Snow line', 'snow_line', boundTo(settings, 'snow_line'), { range: [0, 1.1, 0.01], text: (v) => this.heightText(v) });
    this.change_row = form.slider(body, 'Strongest colours', 'change', boundTo(settings, 'change'), {
      range: [-6, 0, 0.5], toValue: (v) => 2 ** v, toPosition: Math.log2, text: (v) => `\u00b1 ${changeText(v * (this.scene?.maxMoved ?? 0))} m`,
    });
  }

  private addLight(): void {
    const { form, body, settings, sun_rows } = this;
    const addSlider = (title: string, key: 'sun_day' | 'sun_hour' | 'sun_azimuth_deg' | 'sun_height_deg', range: [number, number, number], text: (v: number) => string) =>
      form.slider(body, title, key, boundTo(settings, key), { range, text });
    form.select(body, 'Sun', 'sun', kSunModes, namesOf(kSunModes), boundTo(settings, 'sun'));
    sun_rows.clock.push(addSlider('Day', 'sun_day', [1, 365, 1], dayText), addSlider('Hour', 'sun_hour', [0, 24, 0.25], hourText));
    sun_rows.free.push(addSlider('Azimuth', 'sun_azimuth_deg', [0, 360, 1], degreesText), addSlider('Height', 'sun_height_deg', [0, 90, 1], degreesText));
  }

  private addLayers(): void {
    const { form, body, settings, layer_rows } = this;
    layer_rows.imagery = form.switch(body, 'Imagery', 'imagery', boundTo(settings, 'imagery'));
    layer_rows.relief = form.switch(body, 'Relief shading', 'relief', boundTo(settings, 'relief'));
    layer_rows.shadows = form.switch(body, 'Cast shadows', 'shadows', boundTo(settings, 'shadows'));
    form.switch(body, 'Contours', 'contours', boundTo(settings, 'contours'));
    this.sea_row = form.switch(body, 'Sea', 'sea', boundTo(settings, 'sea'));
    this.sea_row.hidden = true;
    form.switch(body, 'Haze', 'fog', boundTo(settings, 'fog'));
    this.flat_rows.push(form.slider(body, 'Heights', 'exaggeration', boundTo(settings, 'exaggeration'), {
      range: [-1, Math.log2(kExaggerations.most), 0.01], toValue: (v) => Math.round(20 * 2 ** v) / 20, toPosition: Math.log2, text: (v) => `\u00d7 ${Number(v.toFixed(2))}`,
    }));
    form.switch(body, 'Names', 'labels', boundTo(settings, 'labels'));
    this.flat_rows.push(form.switch(body, 'Map', 'map', boundTo(settings, 'map')));
  }

  // The rows of OverlayControl, and where a file is opened.
  private addOverlays(): void {
    const list = Object.assign(element('div', 'overlays'), { id: 'overlays' });
    const file = Object.assign(document.createElement('input'), { type: 'file', id: 'overlay-file', name: 'overlay_file', multiple: true, accept: '.geojson,.json,.kml,.kmz,.gpx,.igc,.csv,.tsv' });
    this.body.append(list);
    this.form.row(this.body, 'Lay on the ground', file);
  }

  private addFlight(speed_mps: Bound<number>): void {
    this.flat_rows.push(this.form.slider(this.body, 'Speed', 'speed', speed_mps, {
      range: [-2, 4.3, 0.05], toValue: (v) => 10 ** v, toPosition: Math.log10, text: (v) => `${metresText(v)}/s`,
    }));
    this.form.slider(this.body, 'Quality', 'quality', boundTo(this.settings, 'tau_px'), {
      range: [-2, 2, 1], toValue: (v) => 2 ** -v, toPosition: (tau_px) => -Math.log2(tau_px), text: qualityText,
    });
  }

  private addLaboratory(): void {
    const { form, laboratory, settings, help } = this;
    form.choice(laboratory, 'Strategy', 'strategy', kStrategies, namesOf(kStrategies), boundTo(settings, 'strategy'));
    laboratory.append(help.strategy);
    form.choice(laboratory, 'Blend', 'blend', kBlends, namesOf(kBlends), boundTo(settings, 'blend'));
    laboratory.append(help.blend);
    const predictors = ['auto', ...kPredictors] as const;
    form.select(laboratory, 'Predictor', 'predictor', predictors, namesOf(predictors), boundTo(settings, 'predictor'));
    form.slider(laboratory, 'Tolerance', 'tau_px', boundTo(settings, 'tau_px'), { range: [-2, 4, 0.25], toValue: (v) => 2 ** v, toPosition: Math.log2, text: pixelsText });
    form.slider(laboratory, 'Keyframes every', 'keyframe_ms', boundTo(settings, 'keyframe_ms'), {
      range: [2, 20, 1], toValue: (v) => 50 * v, toPosition: (v) => v / 50, text: (v) => (adapts(settings) ? 'adaptive' : `${v} ms`),
    });
    this.adaptive_row = form.switch(laboratory, 'Adaptive keyframes', 'adaptive', boundTo(settings, 'adaptive'));
    form.switch(laboratory, 'Wireframe', 'wireframe', boundTo(settings, 'wireframe'));
    form.switch(laboratory, 'Occlusion culling', 'occlusion', boundTo(settings, 'occlusion'));
    form.switch(laboratory, 'Freeze section', 'frozen', boundTo(settings, 'frozen'));
  }

  private heightText(share: number): string {
    if (!this.scene) return `${(100 * share).toFixed(0)} %`;
    const { lowest, highest } = this.scene.heights;
    return share > 1.05 ? 'none' : `${(lowest + share * (highest - lowest)).toFixed(0)} m`;
  }

  // Rows that would do nothing are away.
  private showRows(): void {
    const { sun, ground } = this.settings;
    const { relief, imagery } = this.scene?.layers ?? { relief: true, imagery: true };
    this.layer_rows.relief!.hidden = !relief;
    this.layer_rows.shadows!.hidden = !relief;
    this.layer_rows.imagery!.hidden = !imagery;
    this.adaptive_row.hidden = !mayAdapt(this.settings);
    const is_clock = sun === 'clock' && this.scene?.frame !== 'planar';
    for (const row of this.sun_rows.clock) row.hidden = !is_clock;
    for (const row of this.sun_rows.free) row.hidden = sun === 'map' || is_clock;
    for (const row of this.colour_rows) row.hidden = ground !== 'heights';
    for (const row of this.flat_rows) row.hidden = this.scene?.frame === 'globe';
    this.snow_row.hidden = ground !== 'natural';
    this.showLegend();
  }
  private showLegend(): void {
    const { ground, change } = this.settings, max_moved_m = this.scene?.maxMoved ?? 0;
    const tells_change = ground === 'change' && max_moved_m > 0;
    this.change_row.hidden = !tells_change;
    const ramp_words = ground === 'heights' ? this.heights_legend.words : kLegends[ground] ?? [];
    const words = tells_change ? changeWords(change * max_moved_m) : ramp_words;
    this.legend.className = `legend ${ground}`;
    this.legend.style.backgroundImage = ground === 'heights' ? this.heights_legend.gradient : '';
    this.legend.replaceChildren(...words.map((text) => Object.assign(element('span'), { textContent: text })));
    this.legend.hidden = words.length === 0;
  }

  private changed(): void {
    this.showRows();
    for (const key of ['strategy', 'blend'] as const) this.help[key].textContent = kHelp[this.settings[key]] ?? '';
    this.onChange();
  }
}

// Opens and folds the whole panel, which is open where there is room for it.
function toggleOf(root: HTMLElement): HTMLElement {
  const toggle = Object.assign(document.createElement('button'), { type: 'button', className: 'toggle' });
  toggle.innerHTML = `<span>${said('Settings')}</span><svg viewBox="0 0 16 16" aria-hidden="true"><path d="M4 6l4 4 4-4"/></svg>`;
  const fold = (is_open: boolean) => {
    root.classList.toggle('open', is_open);
    toggle.setAttribute('aria-expanded', String(is_open));
  };
  toggle.onclick = () => fold(!root.classList.contains('open'));
  fold(window.matchMedia('(min-width: 700px) and (min-height: 520px)').matches);
  return toggle;
}

// As it was left on the last visit.
function foldOf(title: string, name: string): HTMLDetailsElement {
  const fold = document.createElement('details');
  fold.append(Object.assign(element('summary'), { textContent: said(title) }));
  fold.open = isRemembered(name);
  fold.ontoggle = () => remember(name, fold.open);
  return fold;
}

function namesOf(values: readonly string[]): string[] {
  return values.map((value) => kNames[value] ?? value);
}
function titleOf(name: string): string {
  return name.charAt(0).toUpperCase() + name.slice(1);
}
