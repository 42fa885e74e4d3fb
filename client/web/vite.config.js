// Builds the page into dist/, which `foreland serve --web` serves. Its client, with the client core and the worker, is the package in
// ../js, which is built before.
import { dirname } from 'node:path';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';

export default defineConfig({
  root: dirname(fileURLToPath(import.meta.url)),
  base: './',
  resolve: { dedupe: ['three'] },
  optimizeDeps: { exclude: ['@foreland/client'] },
  build: { target: 'es2022', chunkSizeWarningLimit: 900, assetsInlineLimit: 0 },
  worker: { format: 'es' },
  // `npm run dev` shows the page with a server that runs elsewhere: foreland serve SCENE --listen 127.0.0.1:8080
  server: { proxy: { '/fly': { target: process.env.FORELAND_SERVER ?? 'http://127.0.0.1:8080', ws: true } } },
});
