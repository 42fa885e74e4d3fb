// Builds the page into dist/, which `foreland serve --web` serves. The client core, foreland.wasm, comes from the `wasm` preset's
// build folder, or from where FORELAND_WASM says.
import { existsSync } from 'node:fs';
import { copyFile, mkdir } from 'node:fs/promises';
import { dirname, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';

const here = dirname(fileURLToPath(import.meta.url));

function clientCore() {
  return {
    name: 'foreland-client-core',
    async buildStart() {
      const from = resolve(process.env.FORELAND_WASM ?? resolve(here, '../../build/wasm/bin/foreland.wasm'));
      if (!existsSync(from)) {
        throw new Error(`${from} is missing. Build it: cmake --preset wasm && cmake --build --preset wasm; or set FORELAND_WASM.`);
      }
      await mkdir(resolve(here, 'public'), { recursive: true });
      await copyFile(from, resolve(here, 'public/foreland.wasm'));
    },
  };
}

export default defineConfig({
  root: here,
  base: './',
  plugins: [clientCore()],
  build: { target: 'es2022', chunkSizeWarningLimit: 900 },
  worker: { format: 'es' },
  // `npm run dev` shows the page with a server that runs elsewhere: foreland serve SCENE --listen 127.0.0.1:8080
  server: { proxy: { '/fly': { target: process.env.FORELAND_SERVER ?? 'http://127.0.0.1:8080', ws: true } } },
});
