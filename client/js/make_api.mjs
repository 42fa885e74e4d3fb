// Writes API.md from the types that the build has made: what each entry of the package exports, with its comments. It is checked in, so
// that a change of the interface is seen; `--check` says whether it is due.
//
//   node make_api.mjs [--check]
import { readFile, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const types = join(here, 'dist/types');
const entries = [['@foreland/client', 'index.d.ts'], ['@foreland/client/three', 'three/index.d.ts'], ['@foreland/client/maplibre', 'maplibre/index.d.ts']];

const read = (path) => readFile(join(types, path), 'utf8').catch(() => null);

// The statements of a file of types, each with its comment.
function statementsOf(text) {
  const found = [];
  for (const match of text.matchAll(/(\/\*\*(?:(?!\*\/)[\s\S])*\*\/\n)?((?:export )?(?:declare )?(?:abstract )?(class|interface|type|const|function|enum) (\w+)[\s\S]*?)(?=\n(?:\/\*\*|\/\/|export|declare|interface|type|import|class|const)|$(?![\s\S]))/g))
    found.push({ name: match[4], kind: match[3], comment: match[1] ?? '', text: match[2].trim() });
  return found;
}

// Private members say nothing to a user.
function publicOf(text) {
  return text.replace(/^export /, '').replace(/^declare /, '').replace(/^ +private [^\n]*;\n/gm, '').replace(/^ +private constructor[^\n]*\n/gm, '');
}

const prose = (comment) => comment.replace(/^\/\*\*\s?|\s*\*\/\n?$/g, '').replace(/^ *\* ?/gm, '').trim();

async function sectionOf([name, path]) {
  const text = await read(path);
  if (text === null) return '';
  const parts = [`\n## \`${name}\`\n`];
  const [intro] = text.match(/^\/\*\*[\s\S]*?\*\//) ?? [];
  if (intro) parts.push(`${prose(`${intro}\n`)}\n`);
  for (const [, names, from] of text.matchAll(/export \{([^}]*)\} from '([^']+)';/g)) {
    const all = statementsOf(await read(join(dirname(path), from.replace(/\.js$/, '.d.ts'))));
    for (const wanted of names.split(',').map((part) => part.trim().replace(/^type /, ''))) {
      const one = all.find((s) => s.name === wanted);
      if (!one) continue;
      parts.push(`### ${wanted}\n`, ...(one.comment ? [`${prose(one.comment)}\n`] : []), '```ts', publicOf(one.text), '```\n');
    }
  }
  return parts.join('\n');
}

const api = `# The interface of @foreland/client\n\nMade from its types by make_api.mjs; not to be edited. [README.md](README.md) says how to begin.\n${(await Promise.all(entries.map(sectionOf))).join('')}`;
const path = join(here, 'API.md');
if (process.argv[2] === '--check') {
  if ((await readFile(path, 'utf8').catch(() => '')) !== api) throw new Error('API.md is not that of the types: node make_api.mjs');
} else {
  await writeFile(path, api);
}
