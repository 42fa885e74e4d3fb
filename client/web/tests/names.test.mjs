// Names over the ground: tables of them, which matter, and which are shown.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openSources } from './support.mjs';

let sources, read, names, layout;
before(async () => {
  sources = await openSources();
  [read, names, layout] = await Promise.all(['overlay/read_overlay.ts', 'overlay/names.ts', 'ui/label_layout.ts'].map((path) => sources.load(path)));
});
after(() => sources?.close());

const on_earth = { is_geographic: true, crs: 'EPSG:4326' }, on_map = { is_geographic: false, crs: 'EPSG:2056' };
const readCsv = (text, map = on_earth, name = 'names.csv') => read.readOverlay(name, typeof text === 'string' ? new TextEncoder().encode(text) : text, map);

test('a table has its places by the headings, whatever separates its columns', () => {
  for (const separator of [',', ';', '\t']) {
    const { features } = readCsv(['Name|Latitude|Longitude|ele', '"Piz, ""Nair"""|46.5|9.8|3056', 'Chur|46,85|9,53|593'].join('\r\n').replaceAll('|', separator).replaceAll(',85', separator === ',' ? '.85' : ',85').replaceAll(',53', separator === ',' ? '.53' : ',53'));
    assert.deepEqual(features.map(({ name }) => name), ['Piz, "Nair"', 'Chur']);
    assert.deepEqual(features.map(({ parts }) => [...parts[0]]), [[9.8, 46.5], [9.53, 46.85]]);
    assert.equal(features[0].properties.ele, '3056');
  }
  const { features } = readCsv('E;N;Name\n2600000;1200000;Bern', on_map);
  assert.deepEqual([...features[0].parts[0]], [2600000, 1200000]);
});

test('a table in Latin-1 is read, and it is said that it is; what is wrong with one is said', () => {
  const { features, notes } = readCsv(Buffer.from('name,lon,lat\nGöschenen,8.59,46.67\nZürich,,\n', 'latin1'));
  assert.equal(features[0].name, 'Göschenen');
  assert.match(notes.join(), /names\.csv is not UTF-8; it was read as Latin-1.*1 rows without a place/);
  assert.throws(() => readCsv('name,where\nBern,there\n'), /names\.csv does not say where its places are: .* It has name, where\./);
  assert.throws(() => readCsv('name,lon,lat\nBern,x,y\n'), /no row with a place/);
  assert.throws(() => readCsv('easting,northing\n2600000,1200000\n'), /eastings and northings, and this scene is in longitude and latitude/);
  assert.throws(() => readCsv('name,lon,lat\nBern,46.9,107.4\n'), /axes seem to be exchanged|not on the earth/);
});

test('a name is written as far as the font goes', () => {
  assert.equal(names.writable('  Göschenen\n Ἀθῆναι  Москва '), 'Göschenen \u25a1θῆναι Москва'.replace('ῆ', '\u25a1'));
  assert.equal(names.writable('富士山'), '');
  assert.equal(names.writable('x'.repeat(60)).length, 40);
});

test('rank comes before population, and that before height', () => {
  const of = (properties) => names.importanceOf({ properties });
  const order = [{ rank: '1' }, { scalerank: '3' }, { population: '1000000' }, { pop: '1000', ele: '4000' }, { ele: '4000' }, { ele: '500' }, {}];
  const importances = order.map(of);
  assert.deepEqual([...importances].sort((a, b) => a - b), importances);
});

// Labels that drift at random, some of which are hidden now and then, in steps of a frame.
test('labels never overlap, and none comes back within 300 ms', () => {
  const seed = Number(process.env.SEED ?? Date.now() % 1e9);
  console.log(`seed ${seed}`);
  let state = seed;
  const random = () => ((state = (state * 48271) % 2147483647) / 2147483647);
  const labels = Array.from({ length: 80 }, (_, id) => ({ id, x: 800 * random(), y: 500 * random(), dx: 60 * (random() - 0.5), dy: 30 * (random() - 0.5), w: 30 + 90 * random(), importance: Math.floor(6 * random()), is_seen: true }));
  const made = new layout.LabelLayout(), gone = new Map();
  let shown_before = new Set(), ever = 0;
  for (let now = 0; now < 20_000; now += 16) {
    const candidates = labels.map(({ id, x, y, dx, dy, w, importance, is_seen }) => {
      const at = [x + (dx * now) / 1000, y + (dy * now) / 1000];
      return { id, box: [at[0], at[1], at[0] + w, at[1] + 16], importance, depth: id, is_seen };
    });
    if (random() < 0.1) labels[Math.floor(80 * random())].is_seen = random() < 0.7;
    const shown = made.update(now, candidates), boxes = candidates.filter(({ id }) => shown.has(id));
    for (const a of boxes)
      for (const b of boxes) assert.ok(a === b || a.box[0] >= b.box[2] || b.box[0] >= a.box[2] || a.box[1] >= b.box[3] || b.box[1] >= a.box[3], `${a.id} and ${b.id} overlap at ${now}`);
    for (const { id } of candidates) {
      if (shown.has(id) && !shown_before.has(id)) {
        assert.ok(now - (gone.get(id) ?? -Infinity) >= 300, `${id} came back too soon at ${now}`);
        ++ever;
      }
      if (!shown.has(id) && shown_before.has(id)) gone.set(id, now);
    }
    shown_before = shown;
  }
  assert.ok(ever > 20);
});

test('a change that does not last 300 ms is not seen', () => {
  const made = new layout.LabelLayout(), at = (now, is_seen) => made.update(now, [{ id: 1, box: [0, 0, 50, 10], importance: 1, depth: 1, is_seen }]).has(1);
  assert.deepEqual([at(0, true), at(299, true), at(300, true)], [false, false, true]);
  assert.deepEqual([at(700, false), at(900, false), at(950, true), at(1100, false), at(1399, false), at(1400, false)], [true, true, true, true, true, false]);
});
