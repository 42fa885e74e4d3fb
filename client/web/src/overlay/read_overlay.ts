// Features of a file (geo_json.ts) as places of a scene. Whatever is in the file is a stranger's: sizes and numbers are checked. Pure.
import { isOfStyle, styleOf, type Feature, type Overlay, type Places } from './feature';
import { kSceneMap } from './csv';
import { geoJsonOf } from './geo_json';
import { epsgOf, titleOf, toMapOf, type ToMap } from './map_coordinates';

const kMaxVertices = 1_000_000;
const kMaxFeatures = 200_000;
const kMaxProperties = 100; // of a feature
const kMaxText = 2000; // of a property, characters
const kMaxDepth = 32; // of collections in one another
const kLeast = { point: 1, line: 2, area: 4 }; // places of a part

// What a scene's places are: longitude and latitude, or coordinates of its map.
export interface OverlayMap {
  is_geographic: boolean;
  crs: string;
}

// An Error says in words what is wrong with the file.
export function readOverlay(name: string, bytes: Uint8Array, map: OverlayMap): Overlay {
  const { json, notes } = geoJsonOf(name, bytes);
  const { features, empty } = new Reader(name, map).read(json);
  return { name, features, notes: empty > 0 ? [...notes, `${empty.toLocaleString('en')} features without places were left out.`] : notes };
}

type Json = Record<string, unknown>;
const isObject = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);

class Reader {
  private readonly features: Feature[] = [];
  private vertices = 0;
  private empty = 0;
  private toMap: ToMap | null = null; // of longitude and latitude; null: places are the scene's already
  private is_lonlat = true;

  constructor(private readonly name: string, private readonly map: OverlayMap) {}

  read(json: unknown): { features: Feature[]; empty: number } {
    if (!isObject(json)) throw this.wrong(json === null ? 'has no points, lines or areas' : 'is no GeoJSON object');
    this.readCrs(json);
    this.readAny(json, {}, 0);
    if (this.features.length === 0) throw this.wrong('has no points, lines or areas');
    return { features: this.features, empty: this.empty };
  }

  private wrong(what: string): Error {
    return new Error(`${this.name} ${what}.`);
  }

  // GeoJSON is in longitude and latitude; older files name another system, and the page's own the scene's, as that is told.
  private readCrs(json: Json): void {
    const { is_geographic, crs } = this.map;
    const name = isObject(json.crs) && isObject(json.crs.properties) ? String(json.crs.properties.name) : '', named = name.slice(0, 100);
    if (named === kSceneMap || (!is_geographic && name === crs)) {
      if (is_geographic) throw this.wrong('has eastings and northings, and this scene is in longitude and latitude: bring it there first');
      this.is_lonlat = false;
      return;
    }
    const code = /EPSG:{1,2}(\d+)$/i.exec(named)?.[1];
    this.is_lonlat = named === '' || /CRS84$/i.test(named) || code === '4326';
    if (this.is_lonlat && !is_geographic) {
      this.toMap = toMapOf(crs);
      if (!this.toMap) throw this.wrong(`is in longitude and latitude, and how the scene's map (${titleOf(crs)}) follows from these is not known here; bring it there first, as by ogr2ogr -t_srs`);
    }
    if (!this.is_lonlat && (is_geographic || code !== epsgOf(crs)))
      throw this.wrong(`is in ${named}; bring it to longitude and latitude first, as by ogr2ogr -t_srs EPSG:4326`);
  }

  private readAny(json: unknown, properties: Json, depth: number): void {
    if (!isObject(json)) return void ++this.empty;
    if (depth > kMaxDepth) throw this.wrong(`has collections in one another, more than ${kMaxDepth} deep`);
    switch (json.type) {
      case 'FeatureCollection': return this.list(json.features).forEach((feature) => this.readAny(feature, {}, depth + 1));
      case 'Feature': return this.readAny(json.geometry, isObject(json.properties) ? json.properties : {}, depth + 1);
      case 'GeometryCollection': return this.list(json.geometries).forEach((geometry) => this.readAny(geometry, properties, depth + 1));
      case 'Point': return this.add('point', [this.line([json.coordinates])], properties);
      case 'MultiPoint': return this.add('point', [this.line(json.coordinates)], properties);
      case 'LineString': return this.add('line', [this.line(json.coordinates)], properties);
      case 'MultiLineString': return this.add('line', this.list(json.coordinates).map((line) => this.line(line)), properties);
      case 'Polygon': return this.add('area', this.list(json.coordinates).map((ring) => this.line(ring)), properties);
      case 'MultiPolygon':
        return this.add('area', this.list(json.coordinates).flatMap((area) => this.list(area).map((ring) => this.line(ring))), properties);
      default: throw this.wrong(`has something of type ${JSON.stringify(json.type)?.slice(0, 40)}, which GeoJSON has not`);
    }
  }

  private list(value: unknown): unknown[] {
    if (!Array.isArray(value)) throw this.wrong('has something else where a list should be');
    return value;
  }
  private line(value: unknown): Places {
    const positions = this.list(value);
    if ((this.vertices += positions.length) > kMaxVertices) throw this.wrong(`has more than ${kMaxVertices.toLocaleString('en')} positions: simplify it, as by ogr2ogr -simplify`);
    const places = new Float64Array(2 * positions.length);
    positions.forEach((position, i) => places.set(this.place(position), 2 * i));
    return places;
  }
  private place(position: unknown): readonly [number, number] {
    const [x, y] = this.list(position);
    if (typeof x !== 'number' || typeof y !== 'number' || !Number.isFinite(x) || !Number.isFinite(y)) throw this.wrong('has a position that is no pair of numbers');
    if (!this.is_lonlat) return [x, y];
    if (Math.abs(y) > 90 && Math.abs(x) <= 90 && Math.abs(y) <= 180) throw this.wrong(`has the latitude ${y}: its axes seem to be exchanged, GeoJSON has longitude first`);
    if (Math.abs(y) > 90 || Math.abs(x) > 540) throw this.wrong(`has the position ${x}, ${y}, which is not on the earth: GeoJSON is in degrees, unless its crs names another system`);
    const place = this.toMap?.(x, y) ?? [x, y];
    if (!place.every(Number.isFinite)) throw this.wrong(`has the position ${x}, ${y}, which the scene's map (${titleOf(this.map.crs)}) does not have`);
    return place;
  }

  private add(kind: Feature['kind'], parts: Places[], properties: Json): void {
    const kept = parts.filter((part) => part.length >= 2 * kLeast[kind]);
    if (kept.length === 0) return void ++this.empty;
    if (this.features.length === kMaxFeatures) throw this.wrong(`has more than ${kMaxFeatures.toLocaleString('en')} features`);
    const texts = Object.entries(properties).map(([key, value]) => [key, textOfProperty(value)] as const).filter(([key, text]) => text !== '' && !isOfStyle(key));
    this.features.push({
      kind, parts: kept, style: styleOf(properties), name: textOfProperty(properties.name ?? properties.title).slice(0, 200),
      properties: Object.fromEntries(texts.slice(0, kMaxProperties).map(([key, text]) => [key.slice(0, 100), text])),
    });
  }
}

// Empty: nothing to read for people. HTML, which KML's descriptions may be in, is brought to plain text.
function textOfProperty(value: unknown): string {
  if (isObject(value) && value['@type'] === 'html') return String(value.value).replace(/<[^>]*>/g, ' ').replace(/&nbsp;/g, ' ').replace(/\s+/g, ' ').trim().slice(0, kMaxText);
  return ['string', 'number', 'boolean'].includes(typeof value) ? String(value).slice(0, kMaxText) : '';
}
