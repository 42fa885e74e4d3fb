// Files of features and the grids that lay them on the ground: what is refused, and that each cell of each level has all that is near it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { after, before, test } from 'node:test';
import { zipSync } from 'fflate';
import { openSources } from './support.mjs';

let sources, read, grids, find, maps, igc;
before(async () => {
  sources = await openSources();
  [read, grids, find, maps, igc] = await Promise.all(
    ['read_overlay', 'ground_grid', 'find_feature', 'map_coordinates', 'igc'].map((name) => sources.load(`overlay/${name}.ts`)));
});
after(() => sources?.close());

const on_earth = { is_geographic: true, crs: 'EPSG:4326' };
const bytesOf = (json) => new TextEncoder().encode(typeof json === 'string' ? json : JSON.stringify(json));
const readAs = (json, map = on_earth, name = 'a.geojson') => read.readOverlay(name, bytesOf(json), map);
const lineAt = (coordinates, properties = {}) => ({ type: 'Feature', properties, geometry: { type: 'LineString', coordinates } });

test('GeoJSON is read with simplestyle, whatever its nesting', () => {
  const { features } = readAs({
    type: 'FeatureCollection',
    features: [
      lineAt([[8, 46], [8.1, 46.1, 500]], { stroke: '#f00', 'stroke-width': 7, name: 'A way', length: 12 }),
      { type: 'Feature', properties: null, geometry: { type: 'GeometryCollection', geometries: [{ type: 'Point', coordinates: [8, 46] }] } },
      { type: 'Feature', properties: { fill: '#00ff00', 'fill-opacity': 2 }, geometry: { type: 'MultiPolygon', coordinates: [[[[8, 46], [9, 46], [9, 47], [8, 46]]]] } },
    ],
  });
  assert.deepEqual(features.map(({ kind }) => kind), ['line', 'point', 'area']);
  assert.deepEqual(features[0].style.stroke, [1, 0, 0]);
  assert.equal(features[0].style.stroke_px, 7);
  assert.equal(features[0].name, 'A way');
  assert.deepEqual(features[0].properties, { name: 'A way', length: '12' }); // the others say how it looks
  assert.deepEqual(features[0].parts, [Float64Array.of(8, 46, 8.1, 46.1)]);
  assert.equal(features[2].style.fill_opacity, 1);
});

test('what is wrong with a file is said', () => {
  const refusals = [
    ['hello', /is no GeoJSON, KML, KMZ, GPX, IGC or CSV/],
    ['{"type": "Feat', /is no JSON/],
    [lineAt([[46, 100], [46.1, 101]]), /axes seem to be exchanged/],
    [lineAt([[500000, 5200000], [500001, 5200000]]), /not on the earth/],
    [lineAt([[8, 'x'], [8, 46]]), /no pair of numbers/],
    [{ type: 'Topology' }, /type "Topology"/],
    [{ type: 'FeatureCollection', features: 7 }, /something else where a list should be/],
    [{ type: 'FeatureCollection', features: [] }, /no points, lines or areas/],
    [{ ...lineAt([[8, 46], [9, 46]]), crs: { properties: { name: 'EPSG:3857' } } }, /is in EPSG:3857/],
    [nested(40), /in one another/],
  ];
  for (const [json, reason] of refusals) assert.throws(() => readAs(json), reason, JSON.stringify(json).slice(0, 80));
  assert.throws(() => readAs(lineAt([[8, 46], [9, 46]]), { is_geographic: false, crs: 'LOCAL_CS["of a quarry"]' }), /of a quarry.*is not known here/);
  const { features } = readAs({ ...lineAt([[5, 6], [7, 8]]), crs: { properties: { name: 'urn:ogc:def:crs:EPSG::26910' } } }, { is_geographic: false, crs: utm10 });
  assert.deepEqual(features[0].parts[0], Float64Array.of(5, 6, 7, 8));
  // Paths and measurements that the page keeps name the scene's system as it is told.
  for (const crs of [utm10, 'ENGCRS["synthetic landscape"]'])
    assert.deepEqual(readAs({ ...lineAt([[5, 6], [7, 8]]), crs: { properties: { name: crs } } }, { is_geographic: false, crs }).features[0].parts[0], Float64Array.of(5, 6, 7, 8));
  assert.throws(() => readAs({ ...lineAt([[5, 6], [7, 8]]), crs: { properties: { name: 'EPSG:32632' } } }, { is_geographic: false, crs: utm10 }), /is in EPSG:32632/);
});
function nested(depth) {
  return depth === 0 ? { type: 'Point', coordinates: [8, 46] } : { type: 'GeometryCollection', geometries: [nested(depth - 1)] };
}

test('a packed file that would fill the memory is refused before it is unpacked', () => {
  const bomb = zipSync({ 'doc.kml': new Uint8Array(80 << 20) }, { level: 9 });
  assert.ok(bomb.length < 1 << 20);
  const readKmz = (name, bytes) => () => read.readOverlay(name, bytes, on_earth);
  assert.throws(readKmz('bomb.kmz', bomb), /doc\.kml in it has more than 64 MB/);
  // One that says it is small takes no more than it says.
  const lie = bomb.slice(), at = lie.lastIndexOf(0x50, lie.length - 23); // of the central directory's entry
  assert.deepEqual([...lie.subarray(at, at + 4)], [0x50, 0x4b, 1, 2]);
  new DataView(lie.buffer).setUint32(at + 24, 1000, true);
  const before = process.memoryUsage().arrayBuffers;
  assert.throws(readKmz('lie.kmz', lie), /lie\.kmz/);
  assert.ok(process.memoryUsage().arrayBuffers - before < 20 << 20);
  assert.throws(readKmz('none.kmz', zipSync({ 'a.txt': new Uint8Array(3) })), /has no \.kml in it/);
  assert.throws(readKmz('torn.kmz', zipSync({ 'doc.kml': new Uint8Array(999) }).subarray(0, 40)), /torn\.kmz cannot be unpacked/);
  const packed = zipSync({ 'files/a.png': new Uint8Array(9), 'doc.kml': bytesOf(kmlOf('<Point><coordinates>8,46,0</coordinates></Point>')) });
  assert.deepEqual(readKmz('good.kmz', packed)().features[0].parts, [Float64Array.of(8, 46)]);
});
function kmlOf(geometry, name = 'A place', head = '<?xml version="1.0" encoding="UTF-8"?>') {
  return `${head}<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Style id="s"><LineStyle><color>7f0000ff</color><width>4</width></LineStyle></Style>
    <Placemark><name>${name}</name><description><![CDATA[A <b>fine</b>&nbsp;one]]></description><styleUrl>#s</styleUrl>${geometry}</Placemark></Document></kml>`;
}

test('KML has its styles, and a description in HTML becomes plain text', () => {
  const { features: [line] } = readAs(kmlOf('<LineString><coordinates>8,46 8.1,46.1,300</coordinates></LineString>'), on_earth, 'a.kml');
  assert.deepEqual([line.kind, line.name, line.style.stroke, line.style.stroke_px], ['line', 'A place', [1, 0, 0], 4]);
  assert.ok(Math.abs(line.style.stroke_opacity - 0.5) < 0.01);
  assert.deepEqual(line.properties, { name: 'A place', description: 'A fine one' });
});

test('XML that is broken, empty or too large is refused in words', () => {
  const gpxOf = (body) => `<gpx xmlns="http://www.topografix.com/GPX/1/1" version="1.1">${body}</gpx>`;
  const refusals = [
    [kmlOf('<LineString>'), /a\.xml is no XML/],
    ['<html><body/></html>', /XML of <html>, not KML or GPX/],
    [gpxOf(''), /has no points, lines or areas/],
    [gpxOf('<trk><trkseg/></trk>'), /has no points, lines or areas/],
    ['<', /a\.xml is no XML/],
    [`<kml>${' '.repeat(50e6)}</kml>`, /more than 16 MB of XML.*ogr2ogr -f GeoJSON/],
    [`<!DOCTYPE kml [<!ENTITY a "aaaaaaaaaa">${'bcdefghi'.replace(/./g, (c, i) => `<!ENTITY ${c} "${`&${'abcdefgh'[i]};`.repeat(10)}">`)}]><kml><Placemark><name>&i;</name></Placemark></kml>`, /a\.xml/],
  ];
  for (const [text, reason] of refusals) assert.throws(() => readAs(text, on_earth, 'a.xml'), reason, text.slice(0, 80));
});

test('Latin-1 is read, by what it says it is or by what it must be', () => {
  const kml = kmlOf('<Point><coordinates>8,46</coordinates></Point>', 'H\u00fctte', '<?xml version="1.0" encoding="ISO-8859-1"?>');
  const stated = read.readOverlay('a.kml', Uint8Array.from(Buffer.from(kml, 'latin1')), on_earth);
  assert.deepEqual([stated.features[0].name, stated.notes], ['H\u00fctte', []]);
  const json = JSON.stringify({ type: 'Feature', properties: { name: 'H\u00fctte' }, geometry: { type: 'Point', coordinates: [8, 46] } });
  const guessed = read.readOverlay('a.geojson', Uint8Array.from(Buffer.from(json, 'latin1')), on_earth);
  assert.equal(guessed.features[0].name, 'H\u00fctte');
  assert.match(guessed.notes[0], /a\.geojson is not UTF-8; it was read as Latin-1/);
  const utf16 = read.readOverlay('a.geojson', Uint8Array.from(Buffer.from(`\ufeff${json}`, 'utf16le')), on_earth);
  assert.deepEqual([utf16.features[0].name, utf16.notes], ['H\u00fctte', []]);
});

test('a track of IGC has its fixes, in time past midnight', () => {
  const text = ['AXXX001', 'HFDTEDATE:311223,01', 'HFPLTPILOTINCHARGE: A. Flyer', 'B2359584600030N00800060EA0100001234', 'BOGUS', 'B0000034600090S00800120WV0100101235', ''].join('\r\n');
  const { geometry, properties } = igc.trackOfIgc(text);
  assert.deepEqual(geometry.coordinates, [[8 + 60 / 60_000, 46 + 30 / 60_000, 1234], [-8 - 120 / 60_000, -46 - 90 / 60_000, 1001]]);
  assert.deepEqual(properties, { pilot: 'A. Flyer', coordinateProperties: { times: ['2023-12-31T23:59:58.000Z', '2024-01-01T00:00:03.000Z'] } });
  const { features: [line] } = readAs(text, on_earth, 'a.igc');
  assert.deepEqual([line.kind, line.properties], ['line', { pilot: 'A. Flyer' }]);
  assert.throws(() => readAs('AXXX001\nB2359584600030N00800060EA0100001234\n', on_earth, 'a.igc'), /has no points, lines or areas/);
});

const utm10 = `PROJCRS["NAD83 / UTM zone 10N",BASEGEOGCRS["NAD83",DATUM["North American Datum 1983",ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]],
PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]],ID["EPSG",4269]],CONVERSION["UTM zone 10N",METHOD["Transverse Mercator",ID["EPSG",9807]],
PARAMETER["Latitude of natural origin",0,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8801]],PARAMETER["Longitude of natural origin",-123,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8802]],
PARAMETER["Scale factor at natural origin",0.9996,SCALEUNIT["unity",1],ID["EPSG",8805]],PARAMETER["False easting",500000,LENGTHUNIT["metre",1],ID["EPSG",8806]],
PARAMETER["False northing",0,LENGTHUNIT["metre",1],ID["EPSG",8807]]],CS[Cartesian,2],AXIS["(E)",east,ORDER[1],LENGTHUNIT["metre",1]],AXIS["(N)",north,ORDER[2],LENGTHUNIT["metre",1]],ID["EPSG",26910]]`;

test('longitudes and latitudes come to a planar scene\'s map as PROJ brings them there', () => {
  const next = random(3);
  const places = Array.from({ length: 300 }, () => [-126 + 6 * next(), 32 + 40 * next()]);
  const theirs = execFileSync('cs2cs', ['-f', '%.5f', 'EPSG:4269', 'EPSG:26910'], { input: places.map(([lon, lat]) => `${lat} ${lon}`).join('\n') }).toString().trim().split('\n').map((line) => line.split(/\s+/).map(Number));
  const compound = `COMPOUNDCRS["with heights",${utm10},VERTCRS["NAVD88 height",VDATUM["North American Vertical Datum 1988"],CS[vertical,1],AXIS["up",up],LENGTHUNIT["metre",1]]]`;
  for (const crs of [utm10, compound]) {
    const { features } = readAs(lineAt(places), { is_geographic: false, crs });
    places.forEach((_, i) => assert.ok(Math.hypot(features[0].parts[0][2 * i] - theirs[i][0], features[0].parts[0][2 * i + 1] - theirs[i][1]) < 1e-3, `${places[i]}`));
  }
  assert.equal(maps.epsgOf(utm10), '26910');
  assert.equal(maps.titleOf(utm10), 'NAD83 / UTM zone 10N');
});

test('the feature at a place is the last of those that a plain reference finds', () => {
  const next = random(21);
  const flat = (line) => Float64Array.from(line.flat());
  for (let round = 0; round < 200; ++round) {
    const features = [], laid = [], shapes = [];
    for (let i = 0; i < 6; ++i) {
      const kind = i % 2 ? 'area' : 'line', line = Array.from({ length: 5 }, () => [40 * next(), 40 * next()]);
      if (kind === 'area') line.push(line[0]);
      features.push({ kind, style: { stroke_px: 2 } });
      laid.push({ outline: [flat(line)], rings: kind === 'area' ? [flat(line)] : [] });
      shapes.push(line);
    }
    // A pixel is half as high on the lattice as it is wide, and askew.
    const at = [40 * next(), 40 * next()], right = [0.2, 0.05], down = [0.02, -0.1], step = 4;
    const pointed = find.pointedAt(at, [at[0] + step * right[0], at[1] + step * right[1]], [at[0] + step * down[0], at[1] + step * down[1]], step);
    const det = right[0] * down[1] - right[1] * down[0];
    const onScreen = ([x, y]) => [((x - at[0]) * down[1] - (y - at[1]) * down[0]) / det, ((y - at[1]) * right[0] - (x - at[0]) * right[1]) / det];
    const hits = shapes.map((line, i) => Math.min(...line.slice(1).map((b, k) => distanceTo([0, 0], [...onScreen(line[k]), ...onScreen(b)]))) <= 5 + 1 || (i % 2 === 1 && isInside([line], at)));
    assert.equal(find.featureAt(features, laid, pointed, 5), features[hits.lastIndexOf(true)] ?? null);
  }
});

// A cube about a ball: places and back, with the faces side by side.
const kSide = 1 << 20, kRad = Math.PI / 180;
const cube = {
  side: kSide,
  at: (lon, lat) => {
    const n = [Math.cos(lat * kRad) * Math.cos(lon * kRad), Math.cos(lat * kRad) * Math.sin(lon * kRad), Math.sin(lat * kRad)];
    const axis = [0, 1, 2].reduce((best, k) => (Math.abs(n[k]) > Math.abs(n[best]) ? k : best), 0), half = (v) => 0.5 + (2 / Math.PI) * Math.atan(v / Math.abs(n[axis]));
    const [u, v] = [half(n[(axis + 1) % 3]), half(n[(axis + 2) % 3])];
    return [(2 * axis + (n[axis] < 0 ? 1 : 0) + Math.min(u, 1 - 1e-15)) * kSide, v * kSide];
  },
  placeOf: ([x, y]) => {
    const face = Math.min(Math.floor(x / kSide), 5), axis = face >> 1, n = [0, 0, 0];
    [n[axis], n[(axis + 1) % 3], n[(axis + 2) % 3]] = [face % 2 ? -1 : 1, ...[x / kSide - face, y / kSide].map((v) => Math.tan((Math.PI / 2) * (v - 0.5)))];
    return [Math.atan2(n[1], n[0]) / kRad, Math.atan2(n[2], Math.hypot(n[0], n[1])) / kRad];
  },
};
const made = (generator) => {
  for (;;) {
    const { done, value } = generator.next();
    if (done) return value;
  }
};
const drawn = async (next) => next(await sources.load('overlay/on_faces.ts'));

test('over a globe a line is drawn along all of its way and nowhere else, on each face what is there', () => drawn(({ piecesOf, kBend }) => {
  const next = random(5);
  for (let round = 0; round < 40; ++round) {
    const span = 10 ** (4 * next() - 2), line = [[360 * next() - 180, 160 * next() - 80]];
    while (line.length < 6) line.push(line.at(-1).map((v, k) => (k ? Math.min(Math.max(v + span * (next() - 0.5), -89), 89) : v + 2 * span * (next() - 0.5))));
    const pieces = made(piecesOf(cube, Float64Array.from(line.flat()))), reach = 1.5 * kBend * kSide;
    for (const piece of pieces) assert.equal(new Set(piece.map(([x]) => Math.floor(x / kSide))).size, 1);
    for (let i = 1; i < line.length; ++i)
      for (let k = 0; k < 40; ++k) {
        const share = next(), at = cube.at(...line[i].map((v, axis) => line[i - 1][axis] + share * (v - line[i - 1][axis])));
        assert.ok(pieces.some((piece) => piece.some((b, j) => j > 0 && distanceTo(at, [...piece[j - 1], ...b]) <= reach)), `round ${round}: ${line[i]} at ${share}`);
      }
    const length = (piece) => piece.slice(1).reduce((sum, b, j) => sum + Math.hypot(b[0] - piece[j][0], b[1] - piece[j][1]), 0);
    for (const piece of pieces)
      for (let j = 1; j < piece.length; ++j) {
        const [lon, lat] = cube.placeOf(piece[j].map((v, axis) => (v + piece[j - 1][axis]) / 2));
        const apart = Math.min(...line.slice(1).flatMap((b, k) => [-720, -360, 0, 360, 720].map((turn) => distanceTo([lon + turn, lat], [...line[k], ...b]))));
        assert.ok(apart * Math.cos(lat * kRad) < 3e-4, `round ${round}: ${lon}, ${lat} is ${apart} degrees off, of ${length(piece)}`);
      }
  }
}));

test('over a globe an area covers what lies in it by longitude and latitude, over edges, corners and poles', () => drawn(({ areaOf }) => {
  const next = random(9), caps = [[[-180, -70], [180, -65], [180, -90], [-180, -90], [-180, -70]], [[-180, -90], [180, -90], [180, 90], [-180, 90], [-180, -90]]];
  for (let round = 0; round < 60; ++round) {
    const [lon, lat] = [360 * next() - 180, 140 * next() - 70], wide = 10 ** (2 * next() - 0.1), corners = 3 + Math.floor(6 * next());
    const star = Array.from({ length: corners }, (_, i) => [Math.cos, Math.sin].map((f, k) => {
      const v = (k ? lat : lon) + (k ? 1 : 2) * wide * (0.3 + next()) * f((2 * Math.PI * i) / corners);
      return k ? Math.min(Math.max(v, -89.9), 89.9) : v;
    }));
    const rings = round < caps.length ? [caps[round]] : [[...star, star[0]], ...(round % 3 ? [] : [star.map(([x, y]) => [lon + (x - lon) / 3, lat + (y - lat) / 3])])];
    const { rings: laid, outline } = made(areaOf(cube, rings.map((ring) => Float64Array.from(ring.flat()))));
    for (const piece of outline) assert.equal(new Set(piece.map(([x]) => Math.floor(x / kSide))).size, 1);
    for (let k = 0; k < 300; ++k) {
      const place = k % 2 ? [360 * next() - 180, Math.asin(2 * next() - 1) / kRad] : [lon + 3 * wide * (next() - 0.5), Math.min(Math.max(lat + 3 * wide * (next() - 0.5), -89), 89)];
      const turns = [-720, -360, 0, 360, 720].map((turn) => [place[0] + turn, place[1]]);
      if (turns.some((at) => rings.some((ring) => ring.some((b, j) => distanceTo(at, [...ring.at(j - 1), ...b]) < 0.01)))) continue;
      const at = cube.at(...place), own = laid.filter(([[x]]) => Math.floor(x / kSide) === Math.floor(at[0] / kSide));
      assert.equal(isInside(own, at), turns.filter((turn) => isInside(rings, turn)).length % 2 === 1, `round ${round}: ${place}`);
    }
  }
}));

// Numbers from 0 to 1, of a seed.
function random(seed) {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}
const isInside = (rings, [x, y]) => rings.reduce((odd, ring) => ring.reduce((is, [ax, ay], i) => {
  const [bx, by] = ring[(i + 1) % ring.length];
  return ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay) ? !is : is;
}, odd), false);
function distanceTo([x, y], [ax, ay, bx, by]) {
  const [dx, dy] = [bx - ax, by - ay], length2 = dx * dx + dy * dy;
  const t = length2 > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / length2, 0), 1) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}

// What a cell says, taken apart.
function itemsOf(grid, cell) {
  const [begin, count] = grid.cells.subarray(2 * cell, 2 * cell + 2), shapes = new Map();
  let shape = null;
  for (const item of grid.items.subarray(begin, begin + count)) {
    const [kind, index] = [item >>> 30, item & 0x3fffffff];
    if (kind === 0) shapes.set(index, (shape = { covers: false, segments: [] }));
    else if (kind === 1) shape.covers = !shape.covers;
    else shape.segments.push(grid.segments.subarray(4 * index, 4 * index + 4));
  }
  return shapes;
}

test('a cell of any level has all lines within its reach, and is inside of what surrounds its middle', () => {
  const next = random(5);
  const walk = (count, step) => {
    let at = [1000 * next(), 700 * next()];
    return Array.from({ length: count }, () => (at = at.map((v) => v + step * (next() - 0.5))));
  };
  const closed = (line) => [...line, line[0]];
  const style = { stroke: [1, 0, 0], stroke_opacity: 1, stroke_px: 3, fill: [0, 1, 0], fill_opacity: 0.5 };
  const shapes = Array.from({ length: 30 }, (_, feature) => (feature % 3 === 0
    ? { kind: 'area', style, feature, parts: [closed(walk(12, 200)), closed(walk(5, 60))] }
    : { kind: 'line', style, feature, parts: [walk(feature === 1 ? 2 : 60, 30)] }));
  const grid = grids.buildGroundGrid(shapes);
  const [x0, y0] = grid.origin;
  grid.levels.forEach(({ columns, rows, begin }, level) => {
    const side = grid.cell * 2 ** level;
    for (let tries = 0; tries < 300; ++tries) {
      const [i, j] = [Math.floor(columns * next()), Math.floor(rows * next())];
      const items = itemsOf(grid, begin + j * columns + i);
      // Any place within half a cell of the cell.
      const at = [(i - 0.5 + 2 * next()) * side, (j - 0.5 + 2 * next()) * side], middle = [(i + 0.5) * side, (j + 0.5) * side];
      shapes.forEach(({ kind, parts }, index) => {
        const found = items.get(index) ?? { covers: false, segments: [] };
        const local = parts.map((part) => part.map(([x, y]) => [x - x0, y - y0]));
        const all = local.flatMap((part) => part.slice(1).map((b, k) => [...part[k], ...b]));
        const nearest = Math.min(...all.map((segment) => distanceTo(at, segment)));
        const here = Math.min(...found.segments.map((segment) => distanceTo(at, segment)), Infinity);
        const off = level === 0 ? 1e-3 : side / 16 + 1e-3; // floats; what is simplified
        const inside_of_cell = at[0] >= i * side && at[0] < (i + 1) * side && at[1] >= j * side && at[1] < (j + 1) * side;
        if (inside_of_cell && nearest < 0.5 * side - off) assert.ok(Math.abs(here - nearest) < off, `level ${level}, shape ${index}: ${here}, not ${nearest}`);
        if (kind === 'area' && Math.min(...all.map((segment) => distanceTo(middle, segment))) > off)
          assert.equal(found.covers, isInside(local, middle), `level ${level}, shape ${index}`);
      });
    }
  });
});

test('simplified lines stay within the tolerance of the whole ones', () => {
  const next = random(9);
  for (let tries = 0; tries < 100; ++tries) {
    const line = Array.from({ length: 50 }, (_, i) => [i, 10 * next()]);
    const few = grids.simplified(line, 2);
    assert.ok(few.length < line.length && few[0] === line[0] && few.at(-1) === line.at(-1));
    for (const point of line) assert.ok(Math.min(...few.slice(1).map((b, k) => distanceTo(point, [...few[k], ...b]))) <= 2);
  }
});

// A line of 100,000 vertices would otherwise hold up the page for a tenth of a second.
test('long lines come to the lattice in short steps', async () => {
  const { onLattice } = await sources.load('overlay/on_lattice.ts'), numbers = Float64Array.from({ length: 20_000 }, (_, i) => 3 * i);
  let read = 0, most = 0, step;
  const part = new Proxy(numbers, { get: (target, key) => {
    read += typeof key === 'string' && /^\d+$/.test(key) ? 1 : 0;
    return Reflect.get(target, key);
  } });
  const terrain = { scene: { frame: 'planar' }, toScene: ({ easting, northing, height }) => [easting, northing, height], place: ([x, y]) => ({ lattice: [x / 3, y / 3] }) };
  for (const work = onLattice(terrain, [{ kind: 'line', parts: [part] }]); !step?.done; read = 0) {
    step = work.next();
    most = Math.max(most, read);
  }
  assert.deepEqual([...step.value[0].outline[0]], Array.from(numbers, (_, i) => i));
  assert.ok(most <= 256, `${most} numbers at once`);
});
