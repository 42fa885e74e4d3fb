// Draws an experiment's report: `node draw.mjs FOLDER` reads the tables that `foreland bench latency`, `load` or
// `tiles` left there, and writes report.html, one page that needs nothing else, and its figures as SVG files beside it. It reads no
// clock and no network; equal tables give equal files.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { drawLatency } from './latency.mjs';
import { drawLoad } from './load.mjs';
import { pageOf } from './page.mjs';
import { drawTiles } from './tiles.mjs';

const kDrawings = { latency: drawLatency, load: drawLoad, tiles: drawTiles };

export function parseCsv(text) {
  const [header, ...rows] = text.trimEnd().split('\n').map((line) => line.split(','));
  const valueOf = (cell) => (cell !== '' && Number.isFinite(Number(cell)) ? Number(cell) : cell);
  return rows.map((row) => Object.fromEntries(header.map((name, i) => [name, valueOf(row[i])])));
}

export function draw(folder) {
  const results = JSON.parse(readFileSync(join(folder, 'results.json'), 'utf8'));
  const drawing = kDrawings[results.experiment];
  if (!drawing) throw new Error(`results.json is of no known experiment: '${results.experiment}'`);
  const table = (name) => parseCsv(readFileSync(join(folder, name), 'utf8'));
  const figures = drawing(results, table);
  for (const figure of figures) writeFileSync(join(folder, `${figure.name}.svg`), figure.svg + '\n');
  writeFileSync(join(folder, 'report.html'), pageOf(results, figures));
  return figures.length;
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  try {
    console.log(`${draw(process.argv[2])} figures`);
  } catch (error) {
    console.log(`failed: ${error.message}`);
    process.exitCode = 1;
  }
}
