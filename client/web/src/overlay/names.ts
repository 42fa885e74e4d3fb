// Names of places that are written over the ground: which of them matter more, and what can be written. Pure.
import type { Feature } from './feature';

const kLetters = /^[\u0020-\u02af\u0370-\u052f\u1e00-\u1ef9\u2010-\u2027\u2030-\u203a]$/u; // that the font of the page has all of
const kLongest = 40; // letters

// As it can be written: letters of other scripts leave a box, and a text of nothing else is empty.
export function writable(name: string): string {
  const letters = [...name.normalize('NFC').replace(/\s+/g, ' ').trim()];
  if (!letters.some((letter) => kLetters.test(letter) && letter !== ' ')) return '';
  const text = letters.map((letter) => (kLetters.test(letter) ? letter : '\u25a1'));
  return text.length > kLongest ? `${text.slice(0, kLongest - 1).join('')}\u2026` : text.join('');
}

// The lower the more important: by rank (`rank`, `scalerank`, `labelrank`), else by population, else by height.
export function importanceOf({ properties }: Pick<Feature, 'properties'>): number {
  const numberOf = (...keys: string[]) => keys.map((key) => Number.parseFloat(properties[key] ?? '')).find(Number.isFinite);
  const rank = numberOf('rank', 'scalerank', 'labelrank');
  if (rank !== undefined) return rank;
  const people = numberOf('population', 'pop', 'pop_max');
  if (people !== undefined) return 10 - Math.log10(Math.max(people, 1));
  const height_m = numberOf('ele', 'elevation', 'height', 'hoehe', 'altitude');
  return height_m === undefined ? 20 : 20 - height_m / 1000;
}
