// The colour maps that can be chosen: those of src/colours, and files that are opened or dropped on the page.
import { colourAt, readColourMap, stretched, tintsOf, type ColourMap, type Tints } from '@foreland/client/three';
import { reasonOf } from './words';

const kMaxBytes = 1 << 20; // of a file
const kLegendColours = 24;

const texts = import.meta.glob('../colours/*.cpt', { query: '?raw', import: 'default', eager: true }) as Record<string, string>;

export interface Legend {
  gradient: string;
  words: string[];
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
  tints(name: string, lowest_m: number, highest_m: number): { tints: Tints; legend: Legend } {
    const map = this.maps.get(name) ?? this.maps.values().next().value!;
    const tints = tintsOf(map, lowest_m, highest_m);
    return { tints, legend: legendOf(map.is_normalised ? stretched(map, tints.low, tints.high) : map, tints.low, tints.high) };
  }
}

function legendOf(map: ColourMap, low: number, high: number): Legend {
  const at = (share: number) => colourAt(map, low + share * (high - low)).map(Math.round);
  const stops = Array.from({ length: kLegendColours }, (_, i) => {
    const colour = `rgb(${at((i + 0.5) / kLegendColours).join(' ')})`;
    return `${colour} ${((100 * i) / kLegendColours).toFixed(1)}% ${((100 * (i + 1)) / kLegendColours).toFixed(1)}%`;
  });
  const words = [0, 0.25, 0.5, 0.75, 1].map((share) => (low + share * (high - low)).toFixed(0));
  words[4] += ' m';
  return { gradient: `linear-gradient(90deg, ${stops.join(', ')})`, words };
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
