// Builds the page into dist/, which `foreland serve --web` serves. Its client, with the client core and the worker, is the package in
// ../js, which is built before.
import { dirname } from 'node:path';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';
import { airBytes, kAirSizes } from './make_air.mjs';

// `virtual:air`: where make_air.mjs's bytes are, and how many texels.
const air = (command) => ({
  name: 'air',
  resolveId: (id) => (id === 'virtual:air' ? `\0${id}` : null),
  async load(id) {
    if (id !== '\0virtual:air') return null;
    const bytes = await airBytes(), sizes = `export const kAirSizes = ${JSON.stringify(kAirSizes)};`;
    if (command === 'serve') return `${sizes} export default 'data:application/octet-stream;base64,${bytes.toString('base64')}';`;
    return `${sizes} export default import.meta.ROLLUP_FILE_URL_${this.emitFile({ type: 'asset', name: 'air.bin', source: bytes })};`;
  },
});

export default defineConfig(({ command }) => ({
  plugins: [air(command)],
  root: dirname(fileURLToPath(import.meta.url)),
  base: './',
  resolve: { dedupe: ['three'] },
  optimizeDeps: { exclude: ['@foreland/client'] },
  build: { target: 'es2022', chunkSizeWarningLimit: 900, assetsInlineLimit: 0 },
  worker: { format: 'es' },
  // `npm run dev` shows the page with a server that runs elsewhere: foreland serve SCENE --listen 127.0.0.1:8080
  server: { proxy: { '/fly': { target: process.env.FORELAND_SERVER ?? 'http://127.0.0.1:8080', ws: true } } },
}));
