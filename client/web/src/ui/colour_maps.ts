// The colour maps that can be chosen: those of src/colours, and files that are opened or dropped on the page.
import { colourAt, readColourMap, stretched, tintsOf, type ColourMap, type Tints } from '@foreland/client/three';

export const kColourFiles = { names: /\.cpt$/i, max_bytes: 1 << 20 };
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
