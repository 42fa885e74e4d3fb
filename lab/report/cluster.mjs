// The figures of `foreland bench load --servers`.
import { coloursOf, legend, Plot, svgOf } from './plot.mjs';

function notInTime(runs, what) {
  const percent = (r) => 100 * r.not_in_time_share;
  return {
    name: 'not_in_time', caption: `Keyframes that were not there in time, of those that the viewers' intervals ask for; ${what}.`,
    svg: svgOf({
      marginLeft: 110, height: 60 + 26 * runs.length, x: { label: 'not in time, %', domain: [0, 1.15 * Math.max(1, ...runs.map(percent))] },
      y: { label: null, domain: runs.map((r) => r.balance) },
      marks: [Plot.barX(runs, { x: percent, y: 'balance', fill: '#4269d0' }),
        Plot.text(runs, { x: percent, y: 'balance', text: (r) => percent(r).toFixed(2), dx: 4, textAnchor: 'start' }), Plot.ruleX([0])],
    }),
  };
}

function overTime(runs, rows, what) {
  const colours = coloursOf(runs.map((r) => r.balance));
  return {
    name: 'in_time', caption: `Keyframes that were there in time, in steps of half a second, as a share of those asked for in the mean (so it goes above 1 by chance); ${what}.`,
    svg: svgOf({
      x: { label: 'time, s' }, y: { label: 'share in time', domain: [0, 1.1] },
      marks: [Plot.ruleY([0, 1]), Plot.line(rows, { x: 'time_s', y: 'in_time', z: 'balance', stroke: (r) => colours.get(r.balance), curve: 'step-after' }), ...legend(colours)],
    }),
  };
}

function servers(runs, rows, what) {
  const colours = coloursOf([...new Set(rows.map((r) => `server ${r.server}`))]);
  return {
    name: 'servers', caption: `Share of each server's workers' time that is used, in steps of half a second; ${what}.`,
    svg: svgOf({
      marginRight: 130, height: 60 + 120 * runs.length, x: { label: 'time, s' }, y: { label: 'used', domain: [0, 1], ticks: 3 },
      fy: { label: null, domain: runs.map((r) => r.balance), axis: 'left' }, marginLeft: 110,
      marks: [Plot.ruleY([0]), Plot.line(rows, { x: 'time_s', y: 'used', fy: 'balance', z: 'server', stroke: (r) => colours.get(`server ${r.server}`) }),
        ...[...colours].map(([name, colour], i) => Plot.text([name], { fy: () => runs[0].balance, frameAnchor: 'top-right', dx: 60, dy: 4 + 16 * i, fill: colour, fontWeight: 'bold' }))],
    }),
  };
}

const happenings = (results) =>
  ['fail', 'drain', 'join'].flatMap((what) => (results[what] ?? []).map((at) => `server ${at.split('@')[0]} ${what}s at ${at.split('@')[1]} s`)).join(', ');

export function drawCluster(results, table) {
  const withBalance = (rows) => rows.map((r) => ({ ...r, balance: results.runs[r.run].balance }));
  const what = [`${results.viewers} viewers (${results.mix}), ${results.servers} servers of ${results.workers} ${results.workers === 1 ? 'worker' : 'workers'}`,
    `tolerance ${results.tau_px} px`, happenings(results)].filter((part) => part !== '').join(', ');
  return [notInTime(results.runs, what), overTime(results.runs, withBalance(table('in_time.csv')), what), servers(results.runs, withBalance(table('servers.csv')), what)];
}
