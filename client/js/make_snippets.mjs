// Compiles the snippets of README.md and of docs/EMBEDDING.md against the package's types, as a user's compiler would.
import { execFileSync } from 'node:child_process';
import { mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const folder = join(here, 'dist-snippets');
await rm(folder, { recursive: true, force: true });
await mkdir(folder, { recursive: true });
let count = 0;
for (const document of ['README.md', '../../docs/EMBEDDING.md'])
  for (const [, code] of (await readFile(join(here, document), 'utf8')).matchAll(/```ts\n([\s\S]*?)```/g)) await writeFile(join(folder, `snippet_${++count}.ts`), `${code}export {};\n`);
await writeFile(join(folder, 'tsconfig.json'), JSON.stringify({
  compilerOptions: { target: 'ES2022', module: 'ESNext', moduleResolution: 'bundler', lib: ['ES2023', 'DOM', 'DOM.Iterable'], types: [], strict: true, noEmit: true, skipLibCheck: true }, include: ['*.ts'],
}));
execFileSync(join(here, 'node_modules/.bin/tsc'), ['-p', folder], { stdio: 'inherit' });
await rm(folder, { recursive: true });
console.log(`${count} snippets compile`);
