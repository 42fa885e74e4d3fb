// The card of a feature that was clicked: its name and what its file says of it.
import { element } from './form';

export class FeatureCard {
  constructor(private readonly root: HTMLElement) {
    window.addEventListener('keydown', (event) => event.code === 'Escape' && this.show(null));
  }

  // Null: none.
  show(found: { title: string; properties: Readonly<Record<string, string>> } | null): void {
    this.root.hidden = found === null;
    if (!found) return;
    const close = Object.assign(document.createElement('button'), { type: 'button', textContent: '\u00d7', ariaLabel: 'Close', onclick: () => this.show(null) });
    const header = element('header'), list = element('dl');
    header.append(Object.assign(element('strong'), { textContent: found.title }), close);
    list.append(...Object.entries(found.properties).filter(([key]) => key !== 'name').flatMap(([key, value]) => [
      Object.assign(element('dt'), { textContent: key }), Object.assign(element('dd'), { textContent: value })]));
    this.root.replaceChildren(header, list);
  }
}
