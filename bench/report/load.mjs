// The figures of `foreland bench load`.
import { coloursOf, legend, Plot, svgOf } from './plot.mjs';

const howOf = (run) => `${run.policy}, ${run.phases}${run.start === 'early' ? ', early' : ''}`;

export function drawLoad(results, table) {
  const runs = results.runs.map((r, i) => ({ ...r, run: i, how: howOf(r) }));
  const colours = coloursOf(runs.map((r) => r.how));
  const withHow = (rows) => rows.map((r) => ({ ...r, how: runs[r.run].how }));
  const use = withHow(table('utilisation.csv')), lateness = withHow(table('lateness.csv'));
  const what = `${results.viewers} viewers, ${results.workers} ${results.workers === 1 ? 'worker' : 'workers'}`;
  return [
    {
      name: 'missed', caption: `Keyframes that missed their deadlines, by policy, phases and start; ${what}.`,
      svg: svgOf({ marginLeft: 200, marginRight: 60, x: { label: 'missed, %', zero: true }, y: { label: null, domain: [...colours.keys()] },
        marks: [Plot.barX(runs, { x: (r) => 100 * r.missed_share, y: 'how', fill: (r) => colours.get(r.how) }),
          Plot.text(runs, { x: (r) => 100 * r.missed_share, y: 'how', text: (r) => `${(100 * r.missed_share).toFixed(2)}`, dx: 4, textAnchor: 'start' }), Plot.ruleX([0])] }),
    },
    {
      name: 'utilisation', caption: `Share of the workers' time that is used, over time; ${what}.`,
      svg: svgOf({ x: { label: 'time, s' }, y: { label: 'used', domain: [0, 1] },
        marks: [Plot.line(use, { x: 'time_s', y: 'used', z: 'how', stroke: (r) => colours.get(r.how), strokeWidth: 1 }), ...legend(colours)] }),
    },
    {
      name: 'lateness', caption: `How late keyframes were done, as shares of them; negative is early; ${what}.`,
      svg: svgOf({ x: { label: 'lateness, ms' }, y: { label: 'share done by then', domain: [0, 1] },
        marks: [Plot.ruleX([0]), Plot.line(lateness, { x: 'lateness_ms', y: 'share', z: 'how', stroke: (r) => colours.get(r.how) }), ...legend(colours)] }),
    },
  ];
}
