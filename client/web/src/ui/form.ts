// Rows of controls that show values and change them. Each part of a form adds its rows to an element of its own.
import { said } from './language';

// A value that a control shows and changes.
export interface Bound<T> {
  get: () => T;
  set: (value: T) => void;
}
export function boundTo<Owner, Key extends keyof Owner>(owner: Owner, key: Key): Bound<Owner[Key]> {
  return { get: () => owner[key], set: (value) => (owner[key] = value) };
}

// How a slider's position stands for a value, and the words for that.
export interface SliderScale {
  range: readonly [low: number, high: number, step: number]; // of positions
  toValue?: (position: number) => number;
  toPosition?: (value: number) => number;
  text: (value: number) => string;
}

export class Form {
  private readonly shown: (() => void)[] = []; // each writes what a control stands at

  constructor(private readonly onChange: () => void) {}

  // All controls, after values have been changed elsewhere.
  show(): void {
    for (const show of this.shown) show();
  }

  // One of a few, all in view. `titles` are in the order of `values`.
  choice<T extends string>(rows: HTMLElement, title: string, name: string, values: readonly T[], titles: readonly string[], bound: Bound<T>): void {
    const group = element('div', 'choice');
    group.setAttribute('role', 'radiogroup');
    group.setAttribute('aria-label', said(title));
    values.forEach((value, i) => {
      const label = element('label');
      const input = Object.assign(document.createElement('input'), { type: 'radio', name, value });
      input.onchange = () => this.change(bound, value);
      this.add(() => (input.checked = bound.get() === value));
      label.append(input, Object.assign(element('span'), { textContent: said(titles[i]!) }));
      group.append(label);
    });
    rows.append(group);
  }

  select<T extends string>(rows: HTMLElement, title: string, name: string, values: readonly T[], titles: readonly string[], bound: Bound<T>): HTMLSelectElement {
    const select = Object.assign(document.createElement('select'), { name });
    values.forEach((value, i) => select.add(new Option(said(titles[i]!), value)));
    select.onchange = () => this.change(bound, select.value as T);
    this.add(() => (select.value = bound.get()));
    this.row(rows, title, select);
    return select;
  }

  slider(rows: HTMLElement, title: string, name: string, bound: Bound<number>, scale: SliderScale): HTMLElement {
    const { range: [min, max, step], text, toValue = (v) => v, toPosition = (v) => v } = scale;
    const slider = Object.assign(document.createElement('input'), { type: 'range', name, min: String(min), max: String(max), step: String(step) });
    const output = element('output');
    slider.oninput = () => this.change(bound, toValue(slider.valueAsNumber));
    this.add(() => {
      const value = bound.get();
      if (toValue(slider.valueAsNumber) !== value) slider.value = String(toPosition(value));
      output.textContent = slider.ariaValueText = text(value);
    });
    const row = this.row(rows, title, output);
    row.classList.add('slider');
    row.append(slider);
    return row;
  }

  switch(rows: HTMLElement, title: string, name: string, bound: Bound<boolean>): HTMLElement {
    const input = Object.assign(document.createElement('input'), { type: 'checkbox', name });
    input.onchange = () => this.change(bound, input.checked);
    this.add(() => (input.checked = bound.get()));
    const row = this.row(rows, title, input);
    row.classList.add('switch');
    return row;
  }

  row(rows: HTMLElement, title: string, control: HTMLElement): HTMLElement {
    const row = element('label', 'row');
    row.append(Object.assign(element('span'), { textContent: said(title) }), control);
    rows.append(row);
    return row;
  }

  private add(show: () => void): void {
    show();
    this.shown.push(show);
  }
  private change<T>(bound: Bound<T>, value: T): void {
    bound.set(value);
    this.show();
    this.onChange();
  }
}

export function element(tag: string, name = ''): HTMLElement {
  const made = document.createElement(tag);
  made.className = name;
  return made;
}
