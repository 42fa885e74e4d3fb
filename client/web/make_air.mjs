// The precomputed textures of @takram/three-atmosphere as the page loads them: the scattering, 8 MB, with half as many steps along each axis but
// the angle to the sun's, by the mean of what lies between (its axes are made for being read so). Gives their bytes; Vite's build emits them.
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { DataUtils } from 'three';

// Texels along each axis, as the package has them and as the page does; a row has `nu` blocks of `mu_s`.
const kWhole = { nu: 8, mu_s: 32, mu: 128, r: 32 };
export const kAirSizes = { nu: 8, mu_s: 16, mu: 64, r: 16 };

const folder = join(dirname(createRequire(import.meta.url).resolve('@takram/three-atmosphere')), '..', 'assets');
const halves = async (name) => {
  const bytes = await readFile(join(folder, name));
  return new Uint16Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};

// One after the other: transmittance, 256 x 64; irradiance, 64 x 16; scattering.
export async function airBytes() {
  const parts = [await halves('transmittance.bin'), await halves('irradiance.bin'), shrunk(await halves('scattering.bin'))];
  return Buffer.concat(parts.map((part) => Buffer.from(part.buffer, part.byteOffset, part.byteLength)));
}

// Where a step of a coarser axis lies on the finer one: the step before, and the share of the one after.
function stepsOf(coarse, fine) {
  return Array.from({ length: coarse }, (_, i) => {
    const at = (i * (fine - 1)) / (coarse - 1), before = Math.min(Math.floor(at), fine - 2);
    return [[before, 1 - (at - before)], [before + 1, at - before]].filter(([, share]) => share > 0);
  });
}

function shrunk(texels) {
  const { nu, mu_s, mu, r } = kAirSizes, out = new Uint16Array(4 * nu * mu_s * mu * r), half = kWhole.mu / 2;
  // Views that meet the ground, and those that do not, have halves of the axis of their own.
  const mus = [...stepsOf(mu / 2, half), ...stepsOf(mu / 2, half).map((steps) => steps.map(([at, share]) => [at + half, share]))];
  const suns = stepsOf(mu_s, kWhole.mu_s), heights = stepsOf(r, kWhole.r);
  let to = 0;
  for (let k = 0; k < r; ++k)
    for (let j = 0; j < mu; ++j)
      for (let n = 0; n < nu; ++n)
        for (let s = 0; s < mu_s; ++s) {
          const sum = [0, 0, 0, 0];
          for (const [z, share_z] of heights[k])
            for (const [y, share_y] of mus[j])
              for (const [x, share_x] of suns[s]) {
                const from = 4 * ((z * kWhole.mu + y) * kWhole.nu * kWhole.mu_s + n * kWhole.mu_s + x);
                for (let c = 0; c < 4; ++c) sum[c] += share_x * share_y * share_z * DataUtils.fromHalfFloat(texels[from + c]);
              }
          for (const v of sum) out[to++] = DataUtils.toHalfFloat(v);
        }
  return out;
}
