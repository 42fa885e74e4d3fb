// The colour maps that can be chosen: those of src/colours, and files that are opened or dropped on the page.
import { reasonOf } from '../core/failure';
import { colourAt, readColourMap, stretched, type ColourMap } from '../core/colour_map';

const kTexels = 2048; // of a baked map
const kMaxBytes = 1 << 20; // of a file
const kLegendColours = 24;

const texts = import.meta.glob('../colours/*.cpt', { query: '?raw', import: 'default', eager: true }) as Record<string, string>;

// Colours over the heights from `low` to `high`.
export interface Tints {
  low: number;
  high: number;
  texels: Uint8Array; // RGBA, sRGB
  legend: { gradient: string; words: string[] };
}

export class ColourMaps {
  private readonly maps = new Map<string, ColourMap>();

  constructor() {
    for (const [path, text] of Object.entries(texts)) this.add(path.replace(/^.*\/|\.cpt$/g, ''), text);
  }
  get names(): string[] {
    return [...this.maps.keys()];
  }
  // Throws an Error that names what is wrong.
  add(name: string, text: string): void {
    this.maps.set(name, readColourMap(text, name));
  }
  // Over a scene's ground.
  tints(name: string, lowest_m: number, highest_m: number): Tints {
    const map = this.maps.get(name) ?? this.maps.values().next().value!;
    return tintsOf(map.is_normalised ? stretched(map, lowest_m, highest_m) : map, lowest_m, Math.max(highest_m, lowest_m + 1e-3));
  }
}

function tintsOf(map: ColourMap, low: number, high: number): Tints {
  const at = (share: number) => colourAt(map, low + share * (high - low)).map(Math.round);
  const texels = new Uint8Array(4 * kTexels);
  for (let i = 0; i < kTexels; ++i) texels.set([...at((i + 0.5) / kTexels), 255], 4 * i);
  const stops = Array.from({ length: kLegendColours }, (_, i) => {
    const colour = `rgb(${at((i + 0.5) / kLegendColours).join(' ')})`;
    return `${colour} ${((100 * i) / kLegendColours).toFixed(1)}% ${((100 * (i + 1)) / kLegendColours).toFixed(1)}%`;
  });
  const words = [0, 0.25, 0.5, 0.75, 1].map((share) => (low + share * (high - low)).toFixed(0));
  words[4] += ' m';
  return { low, high, texels, legend: { gradient: `linear-gradient(90deg, ${stops.join(', ')})`, words } };
}

// Files that are dropped on the page, and one that `input` opens. `onFile`, which is not to throw, is given what is in it.
export function takeFiles(input: HTMLInputElement, onFile: (name: string, text: string) => void, onFailure: (reason: string) => void): void {
  const take = async (files: FileList | null | undefined) => {
    const file = files?.[0];
    if (!file) return;
    if (file.size > kMaxBytes) return onFailure(`${file.name} has more than ${kMaxBytes >> 20} MB.`);
    let text: string;
    try {
      text = await file.text();
    } catch (error) {
      return onFailure(`${file.name} cannot be read: ${reasonOf(error)}`);
    }
    onFile(file.name.replace(/\.cpt$/i, ''), text);
  };
  input.onchange = () => {
    void take(input.files);
    input.value = '';
  };
  window.addEventListener('dragover', (event) => event.preventDefault());
  window.addEventListener('drop', (event) => {
    event.preventDefault();
    void take(event.dataTransfer?.files);
  });
}
