// The track that a file may have, beside what lies on the ground: for a worker, since a tree of XML takes long and much memory. Pure.
import { isCsv } from './csv';
import { geoJsonOf } from './geo_json';

const kMayHaveTimes = /"(coordTimes|coordinateProperties)"/; // of GeoJSON, whose text is looked at before it is parsed

// GeoJSON in which times are told, or of GPX, which is a track without them as well; null: the file has none. An Error says what is wrong with it.
export function trackIn(name: string, bytes: Uint8Array): unknown {
  if (isCsv(name) || (/json$/i.test(name) && !kMayHaveTimes.test(new TextDecoder().decode(bytes)))) return null;
  const { json } = geoJsonOf(name, bytes);
  return /\.gpx$/i.test(name) || tellsTimes(json) ? json : null;
}

interface MayTell {
  features?: unknown;
  properties?: { coordTimes?: unknown; coordinateProperties?: { times?: unknown } } | null;
}

function tellsTimes(json: unknown): boolean {
  const { features, properties } = (json ?? {}) as MayTell;
  if (Array.isArray(features)) return features.some(tellsTimes);
  return (properties?.coordTimes ?? properties?.coordinateProperties?.times ?? null) !== null;
}
