// The ground along a line as a plot. Pointing at it calls onPoint with the place that is nearest, or null.
import type { Profile } from '../measure/profile';
import { heightText, lengthText, type Units } from '../measure/units';

const kWidth = 300, kHeight = 96; // of the plot, in its own units
const kSvg = 'http://www.w3.org/2000/svg';

export class ProfilePlot {
  readonly element = document.createElement('figure');
  private readonly svg = document.createElementNS(kSvg, 'svg');
  private readonly caption = document.createElement('figcaption');
  private profile: Profile | null = null;
  private units: Units = 'metric';

  constructor(private readonly onPoint: (index: number | null) => void) {
    this.svg.setAttribute('viewBox', `0 0 ${kWidth} ${kHeight}`);
    this.svg.setAttribute('preserveAspectRatio', 'none');
    this.svg.setAttribute('role', 'img');
    this.element.className = 'profile';
    this.element.append(this.svg, this.caption);
    this.svg.addEventListener('pointermove', (event) => this.pointAt(event.clientX));
    this.svg.addEventListener('pointerleave', () => this.pointAt(null));
  }

  show(profile: Profile | null, units: Units): void {
    [this.profile, this.units] = [profile, units];
    this.element.hidden = profile === null;
    if (profile) this.draw(profile);
  }

  private draw(profile: Profile): void {
    const known = profile.heights.filter(Number.isFinite);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const at = (i: number): [number, number] => [
      (kWidth * profile.distances[i]!) / Math.max(profile.length_m, 1e-9),
      4 + (kHeight - 8) * (1 - (profile.heights[i]! - low) / Math.max(high - low, 1e-9)),
    ];
    const paths = runsOf(profile.heights).flatMap(([begin, end]) => {
      const line = Array.from({ length: end - begin }, (_, k) => at(begin + k).map((v) => v.toFixed(2)).join(' ')).join('L');
      const floor = (i: number) => `${at(i)[0].toFixed(2)} ${kHeight}`;
      return [pathOf(`M${floor(begin)}L${line}L${floor(end - 1)}Z`, 'ground'), pathOf(`M${line}`, 'line')];
    });
    this.svg.setAttribute('aria-label', `Profile: ${lengthText(profile.length_m, this.units)} long, ${this.heightsText(low, high)}`);
    this.svg.replaceChildren(...paths);
    this.caption.textContent = known.length > 0 ? this.heightsText(low, high) : 'Beyond the data';
  }

  private heightsText(low: number, high: number): string {
    return `${heightText(low, this.units)} to ${heightText(high, this.units)} high`;
  }

  private pointAt(x: number | null): void {
    this.svg.querySelector('.pointed')?.remove();
    const { profile } = this;
    if (x === null || !profile) return this.onPoint(null);
    const { left, width } = this.svg.getBoundingClientRect();
    const index = nearestOf(profile.distances, ((x - left) / width) * profile.length_m);
    const at = ((kWidth * profile.distances[index]!) / Math.max(profile.length_m, 1e-9)).toFixed(2);
    this.svg.append(pathOf(`M${at} 0L${at} ${kHeight}`, 'pointed'));
    const height = profile.heights[index]!;
    this.caption.textContent = `${lengthText(profile.distances[index]!, this.units)} along: ${Number.isFinite(height) ? `${heightText(height, this.units)} high` : 'beyond the data'}`;
    this.onPoint(index);
  }
}

function pathOf(d: string, name: string): SVGPathElement {
  const path = document.createElementNS(kSvg, 'path');
  path.setAttribute('d', d);
  path.setAttribute('class', name);
  path.setAttribute('vector-effect', 'non-scaling-stroke');
  return path;
}

// Parts of the line where the ground is known, each from its first place to one past its last.
function runsOf(heights: readonly number[]): [number, number][] {
  const runs: [number, number][] = [];
  heights.forEach((height, i) => {
    if (!Number.isFinite(height)) return;
    const last = runs[runs.length - 1];
    if (last && last[1] === i) last[1] = i + 1;
    else runs.push([i, i + 1]);
  });
  return runs.filter(([begin, end]) => end - begin > 1);
}

function nearestOf(ascending: readonly number[], value: number): number {
  let [low, high] = [0, ascending.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (ascending[middle]! <= value) low = middle;
    else high = middle;
  }
  return value - ascending[low]! < ascending[high]! - value ? low : high;
}
