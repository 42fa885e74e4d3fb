// Colour palette tables: what GMT writes is read, what is wrong is refused by its line.
import assert from 'node:assert/strict';
import { readdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { openSources, root } from './support.mjs';

let sources, readColourMap, colourAt, stretched;

before(async () => {
  sources = await openSources();
  ({ readColourMap, colourAt, stretched } = await sources.load('three/colour_map.ts'));
});
after(() => sources?.close());

const near = (colour, wanted) => colour.forEach((v, i) => assert.ok(Math.abs(v - wanted[i]) < 0.51, `${colour} is not ${wanted}`));

test('the shipped maps are read, and go from end to end', async () => {
  const folder = join(root, 'client/web/src/colours');
  const names = await readdir(folder);
  assert.ok(names.length >= 4);
  for (const name of names) {
    const map = readColourMap(await readFile(join(folder, name), 'utf8'), name);
    assert.equal(map.is_normalised, true);
    map.slices.slice(1).forEach((s, i) => assert.equal(s.from, map.slices[i].to, name));
  }
});

test('each way to write a colour means the same', () => {
  for (const line of ['0 255 0 0 10 0 0 255', '0 255/0/0 10 0/0/255', '0 #ff0000 10 #0000FF', '0 red 10 blue ; with a label', '0\t0-1-1\t10\t240-1-1 L',
    '# COLOR_MODEL = HSV\n0 0 1 1 10 240 1 1'])
    [[0, [255, 0, 0]], [5, [127.5, 0, 127.5]], [10, [0, 0, 255]]].forEach(([z, wanted]) => near(colourAt(readColourMap(line, 'x'), z), wanted));
  near(colourAt(readColourMap('0 0 100 200', 'x'), 50), [100, 100, 100]);
});

test('below, above and between have their own', () => {
  const map = readColourMap('-10 red 0 red\n5 blue 10 blue\nB black\nF white\nN 1/2/3', 'x');
  for (const [z, wanted] of [[-11, [0, 0, 0]], [-5, [255, 0, 0]], [2, [1, 2, 3]], [7, [0, 0, 255]], [11, [255, 255, 255]]]) near(colourAt(map, z), wanted);
});

test('a range stretches normalised heights, on either side of a hinge', () => {
  const map = readColourMap('# RANGE = -8000/4000\n# HARD_HINGE\n-1 blue 0 white\n0 green 1 red', 'x');
  assert.deepEqual(map.slices.map((s) => [s.from, s.to]), [[-8000, 0], [0, 4000]]);
  near(colourAt(map, -4000), [127.5, 127.5, 255]);
  near(colourAt(map, 2000), [127.5, 127.5, 0]);
  assert.deepEqual(stretched(readColourMap('0 red 1 blue', 'x'), 500, 900).slices.map((s) => [s.from, s.to]), [[500, 900]]);
});

// Any table of ascending heights gives at a height what its own two colours mix to.
test('colours are as written at random heights', () => {
  const seed = Number(process.env.FORELAND_SEED ?? Math.floor(Math.random() * 1e9));
  console.log(`FORELAND_SEED=${seed}`);
  let state = seed;
  const random = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32);
  const heights = [-500];
  for (let i = 0; i < 40; ++i) heights.push(heights[i] + 1 + 300 * random());
  const colours = heights.map(() => [0, 1, 2].map(() => Math.floor(256 * random())));
  const text = heights.slice(1).map((h, i) => `${heights[i]} ${colours[i].join(' ')} ${h} ${colours[i + 1].join('/')}`).join('\n');
  const map = readColourMap(text, 'x');
  for (let k = 0; k < 500; ++k) {
    const i = Math.floor(40 * random()), t = random();
    const z = heights[i] + t * (heights[i + 1] - heights[i]);
    near(colourAt(map, z), colours[i].map((v, c) => v + t * (colours[i + 1][c] - v)));
  }
});

test('what is wrong is refused by its line', () => {
  for (const [text, message] of [
    ['0 red 1 blue\n1 green', /x, line 2: the second height is to be a number/],
    ['0 red 1 nocolour', /x, line 1: "nocolour" is no colour/],
    ['0 1/2 1 blue', /line 1: "1\/2" is no colour/],
    ['\n\n0 256 0 0 1 0 0 0', /line 3: a colour is to lie between 0 and 255, not 256/],
    ['5 red 5 blue', /line 1: the heights do not ascend/],
    ['0 red 2 blue\n1 red 3 blue', /line 2: its heights begin at 1, below the end of the line before, 2/],
    ['0 red 1 blue and more', /line 1: "and" is too much/],
    ['# COLOR_MODEL = CMYK\n0 1 1 1 1 1 1 1 1 1', /line 1: colours of the model CMYK/],
    ['# only a comment', /x has no colours/],
    ['', /x has no colours/],
    ['\x89PNG\r\n\x1a\n', /x, line 1/],
  ]) assert.throws(() => readColourMap(text, 'x'), message, JSON.stringify(text));
});
