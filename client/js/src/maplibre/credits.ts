// Credits of a layer, as a control of the map that looks as the map's own.
import type { IControl } from 'maplibre-gl';

/** @internal */
export class Credits implements IControl {
  private readonly element = document.createElement('div');

  constructor() {
    this.element.className = 'maplibregl-ctrl maplibregl-ctrl-attrib';
    this.show([]);
  }
  show(texts: readonly string[]): void {
    this.element.textContent = texts.join(' | ');
    this.element.style.display = texts.length === 0 ? 'none' : '';
  }
  onAdd(): HTMLElement {
    return this.element;
  }
  onRemove(): void {
    this.element.remove();
  }
}
