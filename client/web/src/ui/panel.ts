// The settings panel. It changes the Settings that it is given and calls onChange.
import { kBlends, kPredictors, kStrategies } from '../core/core';
import type { Settings } from './settings';

const kNames: Record<string, string> = {
  delay: 'Delay', current: 'Current', predict: 'Predict', keyframe: 'Keyframes', geomorph: 'Geomorphs',
  auto: 'Automatic', hold: 'Hold', velocity: 'Constant velocity', acceleration: 'Constant acceleration', path: 'Known path',
};
const kHelp: Record<string, string> = {
  delay: 'Geometry and camera are shown one keyframe late.',
  current: 'The camera is current, the geometry one keyframe late.',
  predict: 'Keyframes are computed ahead, for the predicted camera.',
  keyframe: 'All detail blends from one keyframe to the next.',
  geomorph: 'Each vertex blends by its own timing, within a second.',
};

export class Panel {
  private readonly help = { strategy: element('p', 'help'), blend: element('p', 'help') };
  private readonly body = element('div', 'body');

  constructor(root: HTMLElement, private readonly settings: Settings, private readonly onChange: () => void) {
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
    this.changed();
  }

  private addControls(): void {
    this.addChoice('Strategy', 'strategy', kStrategies);
    this.addChoice('Blend', 'blend', kBlends);
    this.addSelect('Predictor', 'predictor', ['auto', ...kPredictors]);
    this.addSlider('Tolerance', 'tau_px', -2, 4, (v) => 2 ** v, Math.log2, (v) => `${v.toFixed(v < 1 ? 2 : 1)} px`);
    this.addSlider('Keyframes every', 'keyframe_ms', 2, 20, (v) => 50 * v, (v) => v / 50, (v) => `${v} ms`);
    this.addSwitch('Wireframe', 'wireframe');
    this.addSwitch('Relief shading', 'relief');
    this.addSwitch('Imagery', 'imagery');
    this.addSwitch('Contours', 'contours');
    this.addSwitch('Haze', 'fog');
    this.addSwitch('Occlusion culling', 'occlusion');
    this.addSwitch('Freeze section', 'frozen');
  }

  private changed(): void {
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

  private addSelect(title: string, key: 'predictor', values: readonly string[]): void {
    const select = Object.assign(document.createElement('select'), { name: key });
    for (const value of values) select.add(new Option(kNames[value], value));
    select.value = this.settings[key];
    select.onchange = () => {
      this.settings[key] = select.value as Settings[typeof key];
      this.changed();
    };
    this.addRow(title, select);
  }

  private addSlider(title: string, key: 'tau_px' | 'keyframe_ms', min: number, max: number, toValue: (v: number) => number,
                    toSlider: (v: number) => number, text: (v: number) => string): void {
    const slider = Object.assign(document.createElement('input'), { type: 'range', name: key });
    Object.assign(slider, { min: String(min), max: String(max), step: key === 'tau_px' ? '0.25' : '1' });
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
  }

  private addSwitch(title: string, key: 'wireframe' | 'relief' | 'imagery' | 'contours' | 'fog' | 'occlusion' | 'frozen'): void {
    const input = Object.assign(document.createElement('input'), { type: 'checkbox', name: key });
    input.checked = this.settings[key];
    input.onchange = () => {
      this.settings[key] = input.checked;
      this.changed();
    };
    this.addRow(title, input).classList.add('switch');
  }

  private addRow(title: string, control: HTMLElement): HTMLElement {
    const row = element('label', 'row');
    row.append(Object.assign(element('span'), { textContent: title }), control);
    this.body.append(row);
    return row;
  }
}

function element(tag: string, name = ''): HTMLElement {
  const made = document.createElement(tag);
  made.className = name;
  return made;
}
