// Tracks of flight recorders: IGC of the FAI, lines of fixed columns. Pure.

export interface TrackFeature {
  type: 'Feature';
  properties: Record<string, unknown> & { coordinateProperties: { times: string[] } };
  geometry: { type: 'LineString'; coordinates: [lon: number, lat: number, height: number][] };
}

const kFix = /^B(\d\d)(\d\d)(\d\d)(\d\d)(\d{5})([NS])(\d{3})(\d{5})([EW])([AV])(-\d{4}|\d{5})(-\d{4}|\d{5})/;
const kDate = /^HFDTE(?:DATE:)?\s*(\d\d)(\d\d)(\d\d)/;
const kHead = /^H[FOP](PLT|GTY|GID|SIT)[^:]*:\s*(.+)/; // pilot, glider, its registration, site
const kHeads: Record<string, string> = { PLT: 'pilot', GTY: 'glider', GID: 'registration', SIT: 'site' };
const kDay_ms = 86_400_000;

// Whether a text looks like one.
export function isIgc(text: string): boolean {
  return /^\s*A[A-Z0-9]{3}/.test(text) && /^B\d{13}/m.test(text);
}

// As togeojson has a track of GPX: heights of satellites where they are known, of pressure otherwise; times in UTC. A recorder that flies past
// midnight goes on with the next day. Null: it has no two fixes.
export function trackOfIgc(text: string): TrackFeature | null {
  const coordinates: TrackFeature['geometry']['coordinates'] = [], times: string[] = [], about: Record<string, unknown> = {};
  let day_ms = Date.UTC(1970, 0, 1), last_ms = -Infinity;
  for (const line of text.split(/\r?\n/)) {
    const fix = kFix.exec(line), date = kDate.exec(line), head = kHead.exec(line);
    if (date) day_ms = Date.UTC(2000 + Number(date[3]), Number(date[2]) - 1, Number(date[1]));
    if (head) about[kHeads[head[1]!]!] = head[2]!.trim();
    if (!fix) continue;
    const [, hours, minutes, seconds, lat, lat_min, south, lon, lon_min, west, validity, pressure, satellites] = fix as unknown as string[];
    let time_ms = day_ms + 1000 * (3600 * Number(hours) + 60 * Number(minutes) + Number(seconds));
    if (time_ms < last_ms - kDay_ms / 2) [day_ms, time_ms] = [day_ms + kDay_ms, time_ms + kDay_ms];
    last_ms = time_ms;
    const degrees = (whole: string, thousandths: string, is_negative: boolean) => (is_negative ? -1 : 1) * (Number(whole) + Number(thousandths) / 60_000);
    coordinates.push([degrees(lon!, lon_min!, west === 'W'), degrees(lat!, lat_min!, south === 'S'), Number(validity === 'A' ? satellites : pressure)]);
    times.push(new Date(time_ms).toISOString());
  }
  if (coordinates.length < 2) return null;
  return { type: 'Feature', properties: { ...about, coordinateProperties: { times } }, geometry: { type: 'LineString', coordinates } };
}
