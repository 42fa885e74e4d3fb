// Measurements as files: what a spreadsheet reads, and what a map reads.
import type { MapPoint } from '@foreland/client';
import type { Profile } from './profile';

function numbersOf(place: MapPoint): [number, number] {
  return 'lat' in place ? [place.lon, place.lat] : [place.easting, place.northing];
}

export function csvOf({ places, distances, heights }: Profile): string {
  const header = 'lat' in places[0]! ? 'longitude,latitude' : 'easting_m,northing_m';
  const rows = places.map((place, i) => {
    const height = heights[i]!;
    return [...numbersOf(place).map((v) => v.toFixed('lat' in place ? 9 : 4)), distances[i]!.toFixed(3), Number.isFinite(height) ? height.toFixed(3) : ''].join(',');
  });
  return `${header},distance_m,height_m\n${rows.join('\n')}\n`;
}

// A point, a line, or with `area_m2` a polygon. Coordinates of a scene whose data are projected are those of its map, which is named.
export function geoJsonOf(corners: readonly MapPoint[], heights: readonly number[], crs: string, properties: Record<string, number>, is_area: boolean): string {
  const positions = corners.map((corner, i) => [...numbersOf(corner), ...(Number.isFinite(heights[i]) ? [heights[i]!] : [])]);
  const geometry = positions.length === 1 ? { type: 'Point', coordinates: positions[0] }
    : is_area ? { type: 'Polygon', coordinates: [[...positions, positions[0]]] } : { type: 'LineString', coordinates: positions };
  const named = 'lat' in corners[0]! ? {} : { crs: { type: 'name', properties: { name: crs } } };
  return `${JSON.stringify({ type: 'FeatureCollection', ...named, features: [{ type: 'Feature', properties, geometry }] }, null, 1)}\n`;
}
