// Files of features and tracks brought to GeoJSON: GeoJSON itself, KML, KMZ, GPX, IGC and CSV. Pure; a worker or
// Node can do it.
import { gpx, kml } from '@tmcw/togeojson';
import { DOMParser } from '@xmldom/xmldom';
import { isCsv, pointsOfCsv } from './csv';
import { kMaxXmlCharacters, kOverlayKinds } from './file_kinds';
import { textOf } from './file_text';
import { isIgc, trackOfIgc } from './igc';

export interface OpenedFile {
  json: unknown; // whatever a stranger calls GeoJSON, unless it came of another format
  notes: string[]; // what was guessed, in words
}

// Tracks have their times in `coordinateProperties.times`, as togeojson gives them. An Error says what is wrong with the file, by its name.
export function geoJsonOf(name: string, bytes: Uint8Array): OpenedFile {
  const { text, notes } = textOf(name, bytes);
  if (isCsv(name)) {
    const { json, left_out } = pointsOfCsv(name, text);
    return { json, notes: left_out > 0 ? [...notes, `${left_out.toLocaleString('en')} rows without a place were left out.`] : notes };
  }
  const first = text.trimStart()[0];
  if (first === '{') return { json: parsedJson(name, text), notes };
  if (first === '<') return { json: parsedXml(name, text), notes };
  if (isIgc(text)) return { json: trackOfIgc(text), notes };
  throw new Error(`${name} is no ${kOverlayKinds}.`);
}

function parsedJson(name: string, text: string): unknown {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`${name} is no JSON: ${error instanceof Error ? error.message : error}`);
  }
}

function parsedXml(name: string, text: string): unknown {
  if (text.length > kMaxXmlCharacters)
    throw new Error(`${name} has more than ${kMaxXmlCharacters >> 20} MB of XML: bring it to GeoJSON first, as by ogr2ogr -f GeoJSON.`);
  const tree = treeOf(name, text);
  const root = tree.documentElement?.localName ?? '';
  if (root === 'kml') return kml(tree);
  if (root === 'gpx') return gpx(tree);
  throw new Error(`${name} is XML of <${root.slice(0, 40)}>, not KML or GPX.`);
}

function treeOf(name: string, text: string): Document {
  const onError = (level: string, message: string) => {
    if (level !== 'warning') throw new Error(message);
  };
  try {
    return new DOMParser({ onError }).parseFromString(text, 'text/xml') as unknown as Document;
  } catch (error) {
    throw new Error(`${name} is no XML: ${(error instanceof Error ? error.message : String(error)).split('\n')[0]!.slice(0, 200)}`);
  }
}
