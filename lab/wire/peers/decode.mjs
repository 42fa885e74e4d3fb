// Decodes a quantized-mesh tile for `foreland bench wire`, with a decoder that is not ours.
//
//   node decode.mjs IN OUT
//
// IN: a gzipped .terrain file. OUT, little-endian: uint32 vertices, uint32 indices, double lowest and highest height of the header,
// then as uint16 all u, all v, all heights, then the triangle indices as uint32.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { gunzipSync } from 'node:zlib';

const { default: decode } = createRequire(import.meta.url)('@here/quantized-mesh-decoder');

const [input, output] = process.argv.slice(2);
const tile = gunzipSync(readFileSync(input));
// A buffer of its own: the decoder reads from the buffer's beginning.
const { header, vertexData, triangleIndices } = decode(new Uint8Array(tile).buffer);
const counts = Uint32Array.of(vertexData.length / 3, triangleIndices.length);
const heights = Float64Array.of(header.minHeight, header.maxHeight);
const parts = [counts, heights, vertexData, Uint32Array.from(triangleIndices)];
writeFileSync(output, Buffer.concat(parts.map((part) => Buffer.from(part.buffer, part.byteOffset, part.byteLength))));
