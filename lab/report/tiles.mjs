// The figures of `foreland bench tiles`.
import { coloursOf, legend, Plot, svgOf } from './plot.mjs';

const kNames = { foreland: 'ours', 'quantized-mesh': 'tiles, gzip', draco: 'tiles, Draco' };
const howOf = (way) => `${kNames[way.way] ?? way.way}, ${+way.asked_px.toPrecision(2)} px`;

function bars(ways, { name, caption, label, of, unit }) {
  return {
    name, caption,
    svg: svgOf({
      marginLeft: 150, marginRight: 90, height: 60 + 26 * ways.length, x: { label, domain: [0, 1.15 * Math.max(...ways.map(of))] }, y: { label: null, domain: ways.map((w) => w.how) },
      marks: [Plot.barX(ways, { x: of, y: 'how', fill: '#4269d0' }),
        Plot.text(ways, { x: of, y: 'how', text: (w) => `${+of(w).toPrecision(3)} ${unit}`, dx: 4, textAnchor: 'start' }), Plot.ruleX([0])],
    }),
  };
}

function overTime(ways, rows, { name, caption, label, of }) {
  const colours = coloursOf(ways.map((w) => w.how));
  return {
    name, caption,
    svg: svgOf({
      x: { label: 'time after the connection, s' }, y: { label },
      marks: [Plot.ruleY([0]), Plot.line(rows, { x: 'time_s', y: of, z: 'how', stroke: (r) => colours.get(r.how), curve: 'step-after' }), ...legend(colours)],
    }),
  };
}

export function drawTiles(results, table) {
  const ways = results.ways.map((way) => ({ ...way, how: howOf(way) }));
  const rows = table('over_time.csv').map((r) => ({ ...r, how: ways[r.flight].how }));
  const what = `${results.tour ?? results.track}${results.jump ? ' with a jump' : ''}, link ${results.link}; the camera begins to move after 5 s; tiles with their default limit, and with the one that has our error on the screen`;
  return [
    bars(ways, { name: 'bytes', caption: `Bytes down, the first view included; ${what}.`, label: 'kB', of: (w) => 1e-3 * w.bytes, unit: 'kB' }),
    overTime(ways, rows, { name: 'bytes_over_time', caption: `Bytes down over time; ${what}.`, label: 'kB', of: (r) => 1e-3 * r.bytes }),
    overTime(ways, rows, { name: 'triangles_over_time', caption: `Triangles drawn over time; ${what}.`, label: 'triangles', of: (r) => r.triangles }),
    bars(ways, { name: 'error', caption: `Root mean square error on the screen, in flight; ${what}.`, label: 'px', of: (w) => w.rms_px, unit: 'px' }),
    bars(ways, { name: 'jump', caption: `Largest motion of a vertex by level of detail from one frame to the next; ${what}.`, label: 'px', of: (w) => w.jump_max_px, unit: 'px' }),
  ];
}
