// The figures of `foreland bench load`.
import { drawCluster } from './cluster.mjs';
import { coloursOf, legend, Plot, svgOf } from './plot.mjs';

const howOf = (run) => `${run.policy}, ${run.phases}, ${run.start}${run.slack_ms > 0 ? ` +${run.slack_ms} ms` : ''}${run.queues === 'stealing' ? ', stealing' : ''}`;

// Utilisation and lateness are drawn for one policy, since policies differ by less than phases and starts do.
function ofOnePolicy(runs) {
  const policy = runs.some((r) => r.policy === 'edf') ? 'edf' : runs[0].policy;
  return runs.filter((r) => r.policy === policy);
}

function missed(runs, what) {
  const colours = coloursOf(['late', 'early']);
  return {
    name: 'missed', caption: `Keyframes that missed their deadlines, by policy, phases and whether they may start early; ${what}.`,
    svg: svgOf({
      marginLeft: 200, marginRight: 110, height: 60 + 18 * runs.length,
      x: { label: 'missed, %', domain: [0, Math.max(1, ...runs.map((r) => 115 * r.missed_share))] }, y: { label: null, domain: runs.map((r) => r.how) },
      marks: [Plot.barX(runs, { x: (r) => 100 * r.missed_share, y: 'how', fill: (r) => colours.get(r.start) }),
        Plot.text(runs, { x: (r) => 100 * r.missed_share, y: 'how', text: (r) => `${(100 * r.missed_share).toFixed(2)}`, dx: 4, textAnchor: 'start' }),
        Plot.ruleX([0]), ...legend(colours)],
    }),
  };
}

function utilisation(runs, rows, what) {
  const shown = rows.filter((r) => r.time_s < 2);
  return {
    name: 'utilisation', caption: `Share of the workers' time that is used, in steps of 20 ms over the first two seconds measured; ${what}.`,
    svg: svgOf({
      marginLeft: 40, marginRight: 190, height: 60 + 70 * runs.length,
      x: { label: 'time, s' }, y: { label: null, domain: [0, 1], ticks: 2 }, fy: { label: null, domain: runs.map((r) => r.how) },
      marks: [Plot.areaY(shown, { x: 'time_s', y: 'used', fy: 'how', fill: '#4269d0', curve: 'step-after' }), Plot.ruleY([0])],
    }),
  };
}

function lateness(runs, rows, what) {
  const colours = coloursOf(runs.map((r) => r.how));
  return {
    name: 'lateness', caption: `How late keyframes were done, as shares of them; negative is early; ${what}.`,
    svg: svgOf({
      marginRight: 200, x: { label: 'lateness, ms' }, y: { label: 'share done by then', domain: [0, 1] },
      marks: [Plot.ruleX([0]), Plot.line(rows, { x: 'lateness_ms', y: 'share', z: 'how', stroke: (r) => colours.get(r.how) }), ...legend(colours)],
    }),
  };
}

// Deadlines missed and time used against the number of viewers, a line for each way of serving them. The axis of misses
// is linear below 0.1 %, which a line marks, and logarithmic above.
function againstViewers(runs, capacities, what) {
  const colours = coloursOf([...new Set(runs.map((r) => r.how))]);
  const lines = (y) => [Plot.line(runs, { x: 'viewers', y, z: 'how', stroke: (r) => colours.get(r.how) }),
    Plot.dot(runs, { x: 'viewers', y, fill: (r) => colours.get(r.how) }), ...legend(colours)];
  const served = capacities.map((c) => `${c.most_viewers} (${howOf(c)})`).join('; ');
  return [{
    name: 'missed_by_viewers', caption: `Keyframes that missed their deadlines, against the number of viewers. Under 0.1 %, of the numbers tried, up to: ${served}; ${what}.`,
    svg: svgOf({ marginRight: 200, x: { label: 'viewers' }, y: { label: 'missed, %', type: 'symlog', constant: 0.1, domain: [0, 100], ticks: [0, 0.1, 1, 10, 100], tickFormat: String },
      marks: [Plot.ruleY([0]), Plot.ruleY([0.1], { strokeDasharray: '4,4' }), ...lines((r) => 100 * r.missed_share)] }),
  }, {
    name: 'used_by_viewers', caption: `Share of the workers' time that is used, against the number of viewers; ${what}.`,
    svg: svgOf({ marginRight: 200, x: { label: 'viewers' }, y: { label: 'used', domain: [0, 1] }, marks: [Plot.ruleY([0]), ...lines('utilisation')] }),
  }];
}

export function drawLoad(results, table) {
  if (results.servers > 1) return drawCluster(results, table);
  if (results.capacity) {
    const what = `${results.mix}, ${results.workers} ${results.workers === 1 ? 'worker' : 'workers'}, link ${results.link}, occlusion ${results.occlusion}, tolerance ${results.tau_px} px`;
    return againstViewers(results.runs.map((r) => ({ ...r, how: howOf(r) })), results.capacity, what);
  }
  const runs = results.runs.map((r, i) => ({ ...r, run: i, how: howOf(r) })), some = ofOnePolicy(runs);
  const isShown = new Set(some.map((r) => r.run));
  const ofShown = (rows) => rows.filter((r) => isShown.has(r.run)).map((r) => ({ ...r, how: runs[r.run].how }));
  const what = `${results.viewers} viewers (${results.mix}), ${results.workers} ${results.workers === 1 ? 'worker' : 'workers'}, tolerance ${results.tau_px} px`;
  return [
    missed(runs, what),
    utilisation(some, ofShown(table('utilisation.csv')), what),
    lateness(some, ofShown(table('lateness.csv')), what),
  ];
}
