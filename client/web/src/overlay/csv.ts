// Tables of places with names, as CSV: a row of headings, then a row for each place. Pure.

interface PointFeature {
  type: 'Feature';
  properties: Record<string, string>;
  geometry: { type: 'Point'; coordinates: [number, number] };
}
export interface PointCollection {
  type: 'FeatureCollection';
  crs?: { properties: { name: string } };
  features: PointFeature[];
}

// Headings, in small letters, that say what a column is.
const kColumns = {
  lon: ['lon', 'lng', 'long', 'longitude', 'l\u00e4nge'],
  lat: ['lat', 'latitude', 'breite'],
  east: ['easting', 'east', 'e', 'x', 'x_coord'],
  north: ['northing', 'north', 'n', 'y', 'y_coord'],
  name: ['name', 'title', 'label', 'nom', 'nombre', 'ort', 'bezeichnung'],
};
const kNumber = /^\s*[-+]?\d+([.,]\d+)?\s*\u00b0?\s*$/;

// Of places in the coordinates of the scene's map, whatever that is (readOverlay).
export const kSceneMap = 'scene';

// Whether a name and a text look like one.
export const isCsv = (name: string): boolean => /\.(csv|tsv)$/i.test(name);

// Columns are told by their headings. An Error says what is wrong, after the file's name. Rows without a place are left out, and counted.
export function pointsOfCsv(name: string, text: string): { json: PointCollection; left_out: number } {
  const separator = separatorOf(text), [headings, ...rows] = rowsOf(text.replace(/^\ufeff/, ''), separator);
  const columns = (headings ?? []).map((heading) => heading.trim()), lower = columns.map((heading) => heading.toLowerCase());
  const columnOf = (kind: keyof typeof kColumns) => lower.findIndex((heading) => kColumns[kind].includes(heading));
  const [lon, lat, east, north] = [columnOf('lon'), columnOf('lat'), columnOf('east'), columnOf('north')], is_lonlat = lon >= 0 && lat >= 0;
  const [x, y] = is_lonlat ? [lon, lat] : [east, north];
  if (x < 0 || y < 0) throw new Error(`${name} does not say where its places are: its first row is to name a column lon and one lat, or easting and northing. It has ${columns.slice(0, 8).join(', ').slice(0, 120) || 'nothing'}.`);
  const name_at = columnOf('name'), features: PointFeature[] = [];
  let left_out = 0;
  for (const row of rows) {
    const coordinates = [numberOf(row[x]), numberOf(row[y])] as [number, number];
    if (!coordinates.every(Number.isFinite)) {
      if (row.some((cell) => cell.trim() !== '')) ++left_out;
      continue;
    }
    const properties = Object.fromEntries(columns.flatMap((column, i) => (i === x || i === y || column === '' || !row[i]?.trim() ? [] : [[i === name_at ? 'name' : column, row[i]!.trim()]])));
    features.push({ type: 'Feature', properties, geometry: { type: 'Point', coordinates } });
  }
  if (features.length === 0) throw new Error(`${name} has no row with a place.`);
  return { json: { type: 'FeatureCollection', ...(is_lonlat ? {} : { crs: { properties: { name: kSceneMap } } }), features }, left_out };
}

// With a comma or a point before the fraction.
function numberOf(text: string | undefined): number {
  return text !== undefined && kNumber.test(text) ? Number.parseFloat(text.replace(',', '.')) : NaN;
}

// What the first row has most of.
function separatorOf(text: string): string {
  const first = text.split(/\r?\n/, 1)[0]!, count = (separator: string) => first.split(separator).length;
  return ['\t', ';', ','].reduce((best, each) => (count(each) > count(best) ? each : best), ',');
}

// RFC 4180, with any end of line.
function rowsOf(text: string, separator: string): string[][] {
  const rows: string[][] = [[]];
  let cell = '', is_quoted = false;
  const endCell = () => {
    rows[rows.length - 1]!.push(cell);
    cell = '';
  };
  for (let i = 0; i < text.length; ++i) {
    const c = text[i]!;
    if (is_quoted) {
      if (c !== '"') cell += c;
      else if (text[i + 1] === '"') cell += text[++i];
      else is_quoted = false;
    } else if (c === '"' && cell.trim() === '') [cell, is_quoted] = ['', true];
    else if (c === separator) endCell();
    else if (c === '\n' || c === '\r') {
      endCell();
      if (c === '\r' && text[i + 1] === '\n') ++i;
      rows.push([]);
    } else cell += c;
  }
  endCell();
  return rows;
}
