// The server's file of the sea: what it says is read, and bytes that say nothing are refused and end.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readSea, undulationAt } from '../dist/three.js';

// As docs/PROTOCOL.md, section 20, has it.
function fileOf({ drawn = 1, columns, rows, first = [-180, -90], step = [1, 1], unit_m = 0.05, error_m = 0.027 }, values) {
  const numbers = [];
  values.forEach((value, i) => {
    const at = (dx, dy) => (i % columns >= dx && i >= dy * columns ? values[i - dx - dy * columns] : 0), difference = value - at(1, 0) - at(0, 1) + at(1, 1);
    let code = difference < 0 ? -2 * difference - 1 : 2 * difference;
    for (; code >= 128; code = Math.floor(code / 128)) numbers.push((code % 128) + 128);
    numbers.push(code);
  });
  const view = new DataView(new ArrayBuffer(64 + numbers.length));
  [drawn, columns, rows].forEach((value, i) => view.setUint32(4 * i, value, true));
  [...first, ...step, unit_m, error_m].forEach((value, i) => view.setFloat64(16 + 8 * i, value, true));
  new Uint8Array(view.buffer, 64).set(numbers);
  return view.buffer;
}
const shape = { columns: 7, rows: 5, first: [-180, -90], step: [60, 45] };
const values = Array.from({ length: 35 }, (_, i) => Math.round(2000 * Math.sin(i * i)));

test('undulations are read, and are bilinear between their values', () => {
  const { isDrawn, undulations } = readSea(fileOf(shape, values));
  assert.ok(isDrawn && undulations.maxError === 0.027);
  values.forEach((value, i) => {
    const [lon, lat] = [-180 + 60 * (i % 7), -90 + 45 * Math.floor(i / 7)];
    assert.ok(Math.abs(undulationAt(undulations, lat, lon) - 0.05 * value) < 1e-4);
    assert.ok(Math.abs(undulationAt(undulations, lat - 500, lon) - 0.05 * values[i % 7]) < 1e-4 || lat > 400);
  });
  const middle = 0.05 * (values[0] + values[1] + values[7] + values[8]) / 4;
  assert.ok(Math.abs(undulationAt(undulations, -67.5, -150) - middle) < 1e-4);
  assert.deepEqual(readSea(fileOf({ drawn: 0, columns: 0, rows: 0 }, [])), { isDrawn: false, undulations: null });
});

test('bytes that are none are refused', () => {
  const good = new Uint8Array(fileOf(shape, values)), readable = (bytes) => { try { return readSea(bytes.slice().buffer); } catch (error) { assert.equal(error.name, 'ForelandError', error.stack); return null; } };
  assert.ok(readable(good));
  for (let size = 0; size < good.length; ++size) assert.equal(readable(good.slice(0, size)), null, `${size} bytes`);
  assert.equal(readable(Uint8Array.of(...good, 0)), null);
  for (const wrong of [{ drawn: 2 }, { columns: 1 }, { columns: 1 << 30, rows: 1 << 30 }, { step: [0, 1] }, { step: [NaN, 1] }, { first: [Infinity, 0] }, { unit_m: -1 }, { unit_m: 1e9 }, { error_m: NaN }])
    assert.equal(readable(new Uint8Array(fileOf({ ...shape, ...wrong }, values))), null, JSON.stringify(wrong));
  let random = 7;
  for (let i = 0; i < 3000; ++i) {
    const forged = good.slice();
    for (let k = 0; k < 3; ++k) forged[(random = (random * 48271) % 2147483647) % forged.length] = (random = (random * 48271) % 2147483647) % 256;
    const sea = readable(forged);
    if (sea?.undulations) assert.ok(sea.undulations.metres.every((n) => Math.abs(n) <= 1.1e4));
  }
});
