// Flights of gliders and paragliders, as their recorders write them (IGC), brought to GeoJSON with times.

const kDay_ms = 86_400_000;

// An Error says in words what is wrong. Records other than of the date and of fixes are passed over.
export function geoJsonOfIgc(name: string, text: string): Record<string, unknown> {
  const coordinates: number[][] = [], times: string[] = [];
  let day_ms = 0, last_ms = -Infinity;
  for (const line of text.split(/\r\n?|\n/)) {
    const date = /^HFDTE(?:DATE:)?\s*(\d\d)(\d\d)(\d\d)/.exec(line);
    if (date) day_ms = Date.UTC(Number(date[3]) + (Number(date[3]) < 80 ? 2000 : 1900), Number(date[2]) - 1, Number(date[1]));
    const fix = fixOf(line);
    if (!fix) continue;
    let time_ms = day_ms + fix.of_day_ms;
    if (time_ms < last_ms - kDay_ms / 2) time_ms += kDay_ms * Math.round((last_ms - time_ms) / kDay_ms); // past midnight
    last_ms = time_ms;
    coordinates.push([fix.lon, fix.lat, fix.height_m]);
    times.push(new Date(time_ms).toISOString());
  }
  if (coordinates.length < 2) throw new Error(`${name} has no flight: no two B records with a position.`);
  return { type: 'Feature', properties: { name, coordTimes: times }, geometry: { type: 'LineString', coordinates } };
}

// B, hhmmss, ddmmmmm N or S, dddmmmmm E or W, A or V, heights by pressure and by satellites.
function fixOf(line: string): { of_day_ms: number; lon: number; lat: number; height_m: number } | null {
  const b = /^B(\d\d)(\d\d)(\d\d)(\d\d)(\d{5})([NS])(\d{3})(\d{5})([EW])([AV])(-\d{4}|\d{5})(-\d{4}|\d{5})/.exec(line);
  if (!b) return null;
  const lat = (Number(b[4]) + Number(b[5]) / 60_000) * (b[6] === 'S' ? -1 : 1), lon = (Number(b[7]) + Number(b[8]) / 60_000) * (b[9] === 'W' ? -1 : 1);
  if (Math.abs(lat) > 90 || Math.abs(lon) > 180 || (lat === 0 && lon === 0)) return null;
  const by_satellites = Number(b[12]);
  const height_m = b[10] === 'A' && by_satellites !== 0 ? by_satellites : Number(b[11]);
  return { of_day_ms: 1000 * (3600 * Number(b[1]) + 60 * Number(b[2]) + Number(b[3])), lon, lat, height_m };
}
