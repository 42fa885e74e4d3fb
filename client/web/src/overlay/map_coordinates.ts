// Longitude and latitude, which files are in, as coordinates of a planar scene's map. Pure.
import proj4 from 'proj4';

export type ToMap = (lon: number, lat: number) => readonly [easting: number, northing: number];

// The EPSG code of a system in WKT, or written EPSG:...; undefined: it has none.
export function epsgOf(crs: string): string | undefined {
  return /(?:\bID\["EPSG",|\bAUTHORITY\["EPSG","|^EPSG:)(\d+)"?\]*$/.exec(crs.trim())?.[1];
}

// What people call a system in WKT.
export function titleOf(crs: string): string {
  return /^\w+\["([^"]+)"/.exec(crs)?.[1] ?? crs.slice(0, 60);
}

// Null: the system is of a kind that is not known here. Datums are taken for WGS 84's, as maps of the last decades are within two metres.
export function toMapOf(crs: string): ToMap | null {
  try {
    const { forward } = proj4('EPSG:4326', horizontalOf(crs));
    return (lon, lat) => forward([lon, lat]) as [number, number];
  } catch {
    return null;
  }
}

// Of a system with heights, its part in the plane.
function horizontalOf(crs: string): string {
  const begin = crs.search(/\bPROJCR?S\[/);
  if (begin <= 0) return crs;
  let depth = 0;
  for (let i = begin; i < crs.length; ++i) {
    if (crs[i] === '[') ++depth;
    if (crs[i] === ']' && --depth === 0) return crs.slice(begin, i + 1);
  }
  return crs;
}
