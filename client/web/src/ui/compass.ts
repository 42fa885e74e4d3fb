// A compass, whose click turns the view to the north, and a scale bar for the ground in the middle of the view.
import { lengthText } from '../measure/units';

const kRefresh_ms = 250; // of the scale bar
const kWidest_px = 120;

export interface ScaledView {
  now_ms: number;
  heading_rad: number;
  // Metres across a pixel at the ground in the middle of the view; null where it shows none.
  pixelAtGround_m: () => number | null;
}

export class Compass {
  private readonly needle: SVGElement;
  private readonly button = Object.assign(document.createElement('button'), { type: 'button' as const, title: 'Turn to the north' });
  private readonly bar = document.createElement('span');
  private last_ms = -Infinity;

  constructor(root: HTMLElement, onNorth: () => void) {
    this.button.innerHTML = '<svg viewBox="-16 -16 32 32" aria-hidden="true"><g><path class="north" d="M0-12 4 0H-4Z"/><path class="south" d="M0 12 4 0H-4Z"/></g></svg>';
    this.button.onclick = onNorth;
    this.needle = this.button.querySelector('g')!;
    this.bar.className = 'scale';
    root.append(this.bar, this.button);
  }

  update({ now_ms, heading_rad, pixelAtGround_m }: ScaledView): void {
    this.needle.setAttribute('transform', `rotate(${((-heading_rad * 180) / Math.PI).toFixed(1)})`);
    if (now_ms - this.last_ms < kRefresh_ms) return;
    this.last_ms = now_ms;
    const degrees = ((Math.round((heading_rad * 180) / Math.PI) % 360) + 360) % 360;
    this.button.ariaLabel = `Compass: ${degrees} degrees. Turn to the north`;
    const pixel_m = pixelAtGround_m();
    this.bar.hidden = pixel_m === null;
    if (pixel_m === null) return;
    const metres = roundLengthBelow(kWidest_px * pixel_m);
    this.bar.style.width = `${(metres / pixel_m).toFixed(1)}px`;
    this.bar.textContent = lengthText(metres, 'metric');
  }
}

// The largest of 1, 2 and 5 times a power of ten that is at most this.
function roundLengthBelow(metres: number): number {
  const power = 10 ** Math.floor(Math.log10(metres));
  return [5, 2, 1].find((factor) => factor * power <= metres)! * power;
}
