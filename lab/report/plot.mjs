// What the figures share: Observable Plot without a browser, colours, and a legend inside the picture.
import * as Plot from '@observablehq/plot';
import { parseHTML } from 'linkedom';

const kColours = ['#4269d0', '#efb118', '#ff725c', '#6cc5b0', '#3ca951', '#ff8ab7', '#a463f2', '#97bbf5', '#9c6b4e', '#6b7280'];

// `series` in the order of the legend.
export function coloursOf(series) {
  return new Map(series.map((name, i) => [name, kColours[i % kColours.length]]));
}

export function legend(colours) {
  return [...colours].map(([name, colour], i) =>
    Plot.text([name], { frameAnchor: 'top-right', dx: 10, dy: 4 + 16 * i, textAnchor: 'start', text: (d) => d, fill: colour, fontWeight: 'bold' }));
}

// The picture as text, with its size and a white ground, so that it reads alone.
export function svgOf(options) {
  const { document } = parseHTML('<html><body></body></html>');
  const svg = Plot.plot({ document, width: 860, height: 380, marginLeft: 56, marginRight: 170, grid: true,
    style: { fontFamily: 'system-ui, sans-serif', fontSize: '12px', background: 'white' }, ...options });
  svg.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
  return svg.outerHTML.replace(/<br>/g, '');
}

export const quantile = (values, q) => {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length === 0 ? 0 : sorted[Math.floor(q * (sorted.length - 1))];
};

export { Plot };
