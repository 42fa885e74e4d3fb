// Files of features: GeoJSON, KML, KMZ and GPX, as text or packed. Whatever is in them is a stranger's: sizes and numbers are checked, and
// an Error says in words what is wrong.
import { gpx, kml } from '@tmcw/togeojson';
import { unzipSync } from 'fflate';
import type { MapPoint } from '@foreland/client';
import { styleOf, type Feature, type Overlay } from './feature';

const kMaxBytes = 64 << 20; // of a file, and of what is packed in one
const kMaxXmlBytes = 16 << 20; // which no browser parses beside the page
const kMaxVertices = 1_000_000;
const kMaxText = 2000; // of a property, characters
const kMaxDepth = 32; // of collections in one another

export const kOverlayFiles = { names: /\.(geojson|json|kml|kmz|gpx)$/i, max_bytes: kMaxBytes };

// How a file's longitudes and latitudes, or its map's coordinates, stand for places of the scene.
export interface OverlayMap {
  is_geographic: boolean;
  crs: string; // of a scene whose data are projected
}

// A generator, for slices (slices.ts): parsing text is one of them.
export function* readOverlay(name: string, bytes: Uint8Array, map: OverlayMap): Generator<void, Overlay> {
  return yield* new Reader(name, map).read(yield* readFeatures(name, bytes));
}

// As GeoJSON, whatever it is written in; what is in it is not checked.
export function* readFeatures(name: string, bytes: Uint8Array): Generator<void, unknown> {
  if (bytes.length > kMaxBytes) throw new Error(`${name} has more than ${kMaxBytes >> 20} MB.`);
  const is_packed = bytes[0] === 0x50 && bytes[1] === 0x4b; // "PK"
  const text = new TextDecoder('utf-8').decode(is_packed ? unpacked(name, bytes) : bytes);
  yield;
  const json = textKind(name, text) === 'json' ? parsedJson(name, text) : parsedXml(name, text);
  yield;
  return json;
}

function unpacked(name: string, bytes: Uint8Array): Uint8Array {
  let found = '';
  const files = (() => {
    try {
      return unzipSync(bytes, {
        filter: (file) => {
          if (found !== '' || !/\.kml$/i.test(file.name)) return false;
          if (file.originalSize > kMaxBytes) throw new Error(`${name}: ${file.name} in it has more than ${kMaxBytes >> 20} MB.`);
          found = file.name;
          return true;
        },
      });
    } catch (error) {
      throw error instanceof Error && error.message.startsWith(name) ? error : new Error(`${name} cannot be unpacked: ${error instanceof Error ? error.message : error}`);
    }
  })();
  if (found === '') throw new Error(`${name} has no .kml in it.`);
  return files[found]!;
}

function textKind(name: string, text: string): 'json' | 'xml' {
  const first = text.trimStart()[0];
  if (first === '{') return 'json';
  if (first === '<') return 'xml';
  throw new Error(`${name} is neither GeoJSON, KML, KMZ nor GPX.`);
}

function parsedJson(name: string, text: string): unknown {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`${name} is no JSON: ${error instanceof Error ? error.message : error}`);
  }
}

function parsedXml(name: string, text: string): unknown {
  if (text.length > kMaxXmlBytes) throw new Error(`${name} has more than ${kMaxXmlBytes >> 20} MB of XML: bring it to GeoJSON first, as by ogr2ogr -f GeoJSON.`);
  const document = new DOMParser().parseFromString(text, 'text/xml');
  const broken = document.querySelector('parsererror');
  if (broken) throw new Error(`${name} is no XML: ${broken.textContent?.split('\n')[0] ?? ''}`);
  const root = document.documentElement.localName;
  if (root === 'kml') return kml(document);
  if (root === 'gpx') return gpx(document);
  throw new Error(`${name} is XML of <${root}>, not KML or GPX.`);
}

type Json = Record<string, unknown>;
const isObject = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);

class Reader {
  private readonly features: Feature[] = [];
  private vertices = 0;
  private empty = 0;
  private is_map = false; // coordinates are those of the scene's map

  constructor(private readonly name: string, private readonly map: OverlayMap) {}

  *read(json: unknown): Generator<void, Overlay> {
    if (!isObject(json)) throw this.wrong('is no GeoJSON object');
    this.readCrs(json);
    yield* this.readAny(json, {}, 0);
    if (this.features.length === 0) throw this.wrong('has no points, lines or areas');
    const notes = this.empty > 0 ? [`${this.empty} features without places were left out`] : [];
    return { name: this.name, features: this.features, notes };
  }

  private wrong(what: string): Error {
    return new Error(`${this.name} ${what}.`);
  }

  // GeoJSON is in longitude and latitude; older files name another system.
  private readCrs(json: Json): void {
    const named = isObject(json.crs) && isObject(json.crs.properties) ? String(json.crs.properties.name) : '';
    const code = /EPSG:{1,2}(\d+)$/i.exec(named)?.[1];
    const is_lonlat = named === '' || /CRS84$/i.test(named) || code === '4326';
    if (this.map.is_geographic && !is_lonlat) throw this.wrong(`is in ${named}; bring it to longitude and latitude first, as by ogr2ogr -t_srs EPSG:4326`);
    this.is_map = !this.map.is_geographic;
    if (this.is_map && (code === undefined || !this.map.crs.includes(code)))
      throw this.wrong(`is not in the scene's map (${this.map.crs}); bring it there first, as by ogr2ogr -t_srs, or build the scene with --frame geographic`);
  }

  private *readAny(json: unknown, properties: Json, depth: number): Generator<void, void> {
    if (!isObject(json)) return void ++this.empty;
    if (depth > kMaxDepth) throw this.wrong(`has collections in one another, more than ${kMaxDepth} deep`);
    yield;
    switch (json.type) {
      case 'FeatureCollection':
        for (const feature of this.list(json.features)) yield* this.readAny(feature, {}, depth + 1);
        return;
      case 'Feature':
        return yield* this.readAny(json.geometry, isObject(json.properties) ? json.properties : {}, depth + 1);
      case 'GeometryCollection':
        for (const geometry of this.list(json.geometries)) yield* this.readAny(geometry, properties, depth + 1);
        return;
      case 'Point': return this.add('point', [[this.place(json.coordinates)]], properties);
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
  private line(value: unknown): MapPoint[] {
    return this.list(value).map((position) => this.place(position));
  }
  private place(position: unknown): MapPoint {
    const [x, y] = this.list(position);
    if (typeof x !== 'number' || typeof y !== 'number' || !Number.isFinite(x) || !Number.isFinite(y)) throw this.wrong('has a position that is no pair of numbers');
    if (++this.vertices > kMaxVertices) throw this.wrong(`has more than ${kMaxVertices.toLocaleString('en')} positions`);
    if (this.is_map) return { easting: x, northing: y };
    if (Math.abs(y) > 90 && Math.abs(x) <= 90 && Math.abs(y) <= 180) throw this.wrong(`has the latitude ${y}: its axes seem to be exchanged, GeoJSON has longitude first`);
    if (Math.abs(y) > 90 || Math.abs(x) > 540) throw this.wrong(`has the position ${x}, ${y}, which is not on the earth: GeoJSON is in degrees`);
    return { lon: x, lat: y };
  }

  private add(kind: Feature['kind'], parts: MapPoint[][], properties: Json): void {
    const least = { point: 1, line: 2, area: 4 }[kind];
    const kept = parts.filter((part) => part.length >= least);
    if (kept.length === 0) return void ++this.empty;
    const texts = Object.entries(properties).filter(([, value]) => ['string', 'number', 'boolean'].includes(typeof value));
    this.features.push({
      kind, parts: kept, style: styleOf(properties), name: String(properties.name ?? properties.title ?? '').slice(0, 200),
      properties: Object.fromEntries(texts.slice(0, 100).map(([key, value]) => [key.slice(0, 100), String(value).slice(0, kMaxText)])),
    });
  }
}
