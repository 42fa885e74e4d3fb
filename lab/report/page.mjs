// The page of a report: figures with their captions, how they were made, and the table of all figures.
const escape = (text) => String(text).replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;');
const shorten = (value) => (typeof value === 'number' ? String(+value.toPrecision(4)) : escape(value));

const kStyle = `body{font:15px/1.5 system-ui,sans-serif;max-width:960px;margin:2em auto;padding:0 1em;color:#222}
figure{margin:2em 0}figcaption{color:#444;margin-top:.4em}svg{max-width:100%;height:auto}code{background:#f3f3f3;padding:.1em .3em}
.made{color:#777;font-size:13px}.table{overflow-x:auto}table{border-collapse:collapse;font-size:12px;white-space:nowrap}td,th{padding:.15em .6em;text-align:right;border-bottom:1px solid #eee}`;

function tableOf(rows) {
  if (!rows || rows.length === 0) return '';
  const names = Object.keys(rows[0]);
  const head = names.map((name) => `<th>${escape(name)}</th>`).join('');
  const body = rows.map((row) => `<tr>${names.map((name) => `<td>${shorten(row[name])}</td>`).join('')}</tr>`).join('\n');
  return `<div class="table"><table><tr>${head}</tr>\n${body}</table></div>`;
}

export function pageOf(results, figures) {
  const made = `<code>${escape(results.command)}</code>, seed ${escape(results.seed)}, calibration ${escape(results.calibration)}, version ${escape(results.version)}`;
  const title = `foreland bench ${escape(results.experiment)}: ${escape(results.scene)}`;
  const drawn = figures.map((f) => `<figure>\n${f.svg}\n<figcaption>${escape(f.caption)}<div class="made">${made}</div></figcaption></figure>`).join('\n');
  return `<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>${title}</title><style>${kStyle}</style></head>
<body><h1>${title}</h1><p>${made}</p>
${drawn}
<h2>All figures</h2>
${tableOf(results.cells ?? results.runs ?? results.ways)}
</body></html>
`;
}
