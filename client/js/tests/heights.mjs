// A raster's heights, and rays over them: what the page draws is judged by it, and shares no code with it.
import { execFile } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { promisify } from 'node:util';

const run = promisify(execFile);

// Of a square raster with north up; positions count samples from its south-western one.
export async function readHeights(raster) {
  const out = `${raster}.envi`;
  await run('gdal_translate', ['-q', '-of', 'ENVI', '-ot', 'Float32', raster, out]);
  const { buffer, byteOffset, length } = await readFile(out);
  const header = await readFile(`${raster}.hdr`, 'utf8').catch(() => readFile(out.replace(/\.envi$/, '.hdr'), 'utf8'));
  const side = Number(header.match(/samples\s*=\s*(\d+)/)[1]);
  const spacing_m = Number(header.match(/map info\s*=\s*\{(.*)\}/)[1].split(',')[5]);
  const data = new Float32Array(buffer, byteOffset, length / 4);
  const at = (x, y) => data[(side - 1 - y) * side + x];
  const between = (x, y) => {
    const [i, j] = [Math.min(Math.floor(x), side - 2), Math.min(Math.floor(y), side - 2)];
    const [u, v] = [x - i, y - j];
    return (at(i, j) * (1 - u) + at(i + 1, j) * u) * (1 - v) + (at(i, j + 1) * (1 - u) + at(i + 1, j + 1) * u) * v;
  };
  return {
    side,
    at,
    // By how much the ray that leaves a sample towards the sun (east, north, rise a level metre) stays below other ground at most.
    shadowOver(x, y, [east, north, rise]) {
      let most = -Infinity;
      for (let t = 1; ; t += 0.25) {
        const [px, py] = [x + t * east, y + t * north];
        if (px < 0 || py < 0 || px > side - 1 || py > side - 1) return most;
        most = Math.max(most, between(px, py) - at(x, y) - t * spacing_m * rise);
      }
    },
    facesSun(x, y, [east, north, rise]) {
      const [dx, dy] = [(at(x + 1, y) - at(x - 1, y)) / (2 * spacing_m), (at(x, y + 1) - at(x, y - 1)) / (2 * spacing_m)];
      return (rise - dx * east - dy * north) / (Math.hypot(dx, dy, 1) * Math.hypot(1, rise)) > 0.12;
    },
  };
}
