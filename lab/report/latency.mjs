// The figures of `foreland bench latency`.
import { coloursOf, legend, Plot, svgOf } from './plot.mjs';

const kTerms = ['refinement', 'interpolation', 'view', 'extrapolation'];
const kMin_px = 0.05; // of logarithmic axes

const howOf = (cell) => (cell.predictor === 'none' ? cell.strategy : `${cell.strategy} ${cell.predictor}`);
const kLog_px = { type: 'log', tickFormat: (px) => `${+px.toPrecision(2)}` };
const clamp = (px) => Math.max(px, kMin_px);

// Of keyframes, in milliseconds.
const isAdaptive = (c) => c.longest_keyframe_ms > 0;
const intervalOf = (c) => (isAdaptive(c) ? `${c.keyframe_ms} to ${c.longest_keyframe_ms}` : `${c.keyframe_ms}`);

// The interval and tolerance that most flights have: those that vary the round trip.
function mainCells(cells) {
  const count = new Map();
  const key = (c) => `${intervalOf(c)} ${c.tau_px}`;
  for (const c of cells) count.set(key(c), (count.get(key(c)) ?? 0) + 1);
  const most = [...count].reduce((a, b) => (b[1] > a[1] ? b : a))[0];
  return cells.filter((c) => key(c) === most);
}

// The flights over one link that the figures of single flights show: the round trip nearest to 200 ms.
function shownCells(cells) {
  const nearest = Math.min(...cells.map((c) => Math.abs(c.round_trip_ms - 200)));
  return cells.filter((c) => Math.abs(c.round_trip_ms - 200) === nearest);
}

const about = (c) => `keyframes each ${intervalOf(c)} ms, tolerance ${c.tau_px} px`;

function againstLatency(cells, colours, norm, words) {
  const fixed = cells.filter((c) => c.link === 'fixed');
  if (new Set(fixed.map((c) => c.round_trip_ms)).size < 2) return [];
  const channels = { x: 'round_trip_ms', y: (c) => clamp(c[`total_${norm}_px`]), z: 'how', stroke: (c) => colours.get(c.how) };
  return [{
    name: `error_against_latency_${norm}`,
    caption: `Total error against the truth, ${words}, over the round trip; ${about(fixed[0])}. The dashed line is the tolerance.`,
    svg: svgOf({
      x: { label: 'round trip, ms' },
      y: { label: `total error, ${words}, px`, ...kLog_px },
      marks: [Plot.ruleY([fixed[0].tau_px], { strokeDasharray: '4 4' }), Plot.line(fixed, channels), Plot.dot(fixed, channels), ...legend(colours)],
    }),
  }];
}

function termsOf(cells, colours) {
  const rows = cells.flatMap((c) => kTerms.map((term) => ({ how: c.how, term, px: c[`${term}_p99_px`] }))).filter((r) => r.px > 0);
  const shades = coloursOf(kTerms);
  return {
    name: 'terms',
    caption: `The error terms apart, 99th percentile over frames of the largest in a frame, beside the total (black); round trip ${cells[0].round_trip_ms} ms, ${about(cells[0])}. The total is at most their sum in every frame.`,
    svg: svgOf({
      marginLeft: 170, height: 60 + 70 * colours.size,
      x: { label: 'px' }, y: { label: null, domain: kTerms, axis: null }, fy: { label: null, domain: [...colours.keys()], axis: 'left' },
      marks: [Plot.barX(rows, { x: 'px', y: 'term', fy: 'how', fill: (r) => shades.get(r.term) }),
        Plot.ruleX(cells, { x: 'total_p99_px', fy: 'how', stroke: 'black', strokeWidth: 2 }), ...legend(shades)],
    }),
  };
}

function overTime(frames, keyframes, colours, first) {
  const channels = { x: 'time_s', y: (f) => clamp(f.total_max_px), z: 'how', stroke: (f) => colours.get(f.how) };
  return {
    name: 'error_over_time',
    caption: `The largest error of each judged frame over the flight; round trip ${first.round_trip_ms} ms, ${about(first)}. Ticks at the foot: keyframes of ${first.how} as they arrive.`,
    svg: svgOf({
      x: { label: 'time, s' }, y: { label: 'total error, px', ...kLog_px },
      marks: [Plot.tickX(keyframes.filter((k) => k.cell === first.cell), { x: 'time_s', y: null, insetTop: 300, stroke: '#bbb' }),
        Plot.line(frames, channels), ...legend(colours)],
    }),
  };
}

function bytesOverTime(keyframes, colours, first) {
  const channels = { x: 'time_s', y: (k) => k.bytes / 1000, z: 'how', stroke: (k) => colours.get(k.how) };
  return {
    name: 'bytes_over_time',
    caption: `Bytes of each keyframe as it arrives; round trip ${first.round_trip_ms} ms, ${about(first)}.`,
    svg: svgOf({
      x: { label: 'time, s' }, y: { label: 'kB a keyframe', zero: true },
      marks: [Plot.ruleY([0]), Plot.line(keyframes, channels), Plot.dot(keyframes, { ...channels, r: 2 }), ...legend(colours)],
    }),
  };
}

function histogram(frames, colours, first) {
  return {
    name: 'error_histogram',
    caption: `How many judged frames have which largest error; round trip ${first.round_trip_ms} ms, ${about(first)}.`,
    svg: svgOf({
      marginLeft: 170, height: 60 + 60 * colours.size,
      y: { label: null, axis: null }, fy: { label: null, domain: [...colours.keys()], axis: 'left' },
      marks: [Plot.rectY(frames, Plot.binX({ y: 'count' }, { x: { value: (f) => Math.log10(clamp(f.total_max_px)), thresholds: 40 }, fy: 'how', fill: (f) => colours.get(f.how) }))],
      x: { label: 'total error, px', tickFormat: (v) => `${+(10 ** v).toPrecision(2)}` },
    }),
  };
}

function intervals(cells, colours) {
  const main = mainCells(cells)[0];
  const rows = cells.filter((c) => c.round_trip_ms === 200 && c.tau_px === main.tau_px && c.link === 'fixed');
  const several = rows.filter((c) => rows.some((d) => d.how === c.how && intervalOf(d) !== intervalOf(c)));
  if (several.length === 0) return [];
  const channels = { x: 'down_kbit_s', y: (c) => clamp(c.total_p99_px), z: 'how', stroke: (c) => colours.get(c.how) };
  return [{
    name: 'error_against_bytes',
    caption: `Total error (99th percentile over frames of the largest) against what the link carries down, for keyframe intervals of ${[...new Set(several.map(intervalOf))].join(', ')} ms; round trip 200 ms.`,
    svg: svgOf({
      x: { label: 'down, kbit/s' }, y: { label: 'total error, p99, px', ...kLog_px },
      marks: [Plot.line(several.filter((c) => !isAdaptive(c)), { ...channels, sort: 'keyframe_ms' }), Plot.dot(several, channels),
        Plot.text(several, { ...channels, stroke: null, fill: 'black', text: (c) => `${intervalOf(c)} ms`, dy: -9 }), ...legend(colours)],
    }),
  }];
}

export function drawLatency(results, table) {
  const cells = results.cells.map((c, i) => ({ ...c, cell: i, how: howOf(c) }));
  const colours = coloursOf([...new Set(cells.map((c) => c.how))]);
  const main = mainCells(cells), shown = shownCells(main);
  const isShown = new Map(shown.map((c) => [c.cell, c]));
  const ofShown = (rows) => rows.filter((r) => isShown.has(r.cell)).map((r) => ({ ...r, how: isShown.get(r.cell).how }));
  const frames = ofShown(table('frames.csv')), keyframes = ofShown(table('keyframes.csv'));
  return [
    ...againstLatency(main, colours, 'p99', '99th percentile over frames of the largest'),
    ...againstLatency(main, colours, 'rms', 'root mean square'),
    termsOf(shown, colours),
    overTime(frames, keyframes, colours, shown[0]),
    histogram(frames, colours, shown[0]),
    bytesOverTime(keyframes, colours, shown[0]),
    ...intervals(cells, colours),
  ];
}
