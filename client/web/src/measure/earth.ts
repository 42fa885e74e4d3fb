// Lengths and areas where a scene lies: geodesics on WGS84 or its body's ellipsoid, or straight lines on the map of a scene whose data are projected.
import type { MapPoint, Scene } from '@foreland/client';
import geographiclib from 'geographiclib-geodesic';

export interface Earth {
  // Metres.
  distance(from: MapPoint, to: MapPoint): number;
  // `count` places on the shortest line, both ends among them, at equal distances; count > 1.
  along(from: MapPoint, to: MapPoint, count: number): MapPoint[];
  // Square metres inside of a closed line of shortest lines, whichever way it goes.
  area(ring: readonly MapPoint[]): number;
  // So far away, in the direction of so many metres to the east and to the north; and the other way round.
  offset(from: MapPoint, east_m: number, north_m: number): MapPoint;
  towards(from: MapPoint, to: MapPoint): [east_m: number, north_m: number];
}

export function earthOf(scene: Pick<Scene, 'frame'> & { ellipsoid?: Scene['ellipsoid'] }): Earth {
  const { ellipsoid } = scene;
  if (scene.frame === 'planar') return kMap;
  return ellipsoid && ellipsoid.semiMajor !== WGS84.a ? onEllipsoid(new geographiclib.Geodesic.Geodesic(ellipsoid.semiMajor, ellipsoid.flattening)) : kEllipsoid;
}

type Geographic = Extract<MapPoint, { lat: number }>;
type Projected = Extract<MapPoint, { easting: number }>;

const { WGS84 } = geographiclib.Geodesic;
const onEllipsoid = (geodesic: typeof WGS84): Earth => ({
  distance(from, to) {
    const [a, b] = [from, to] as [Geographic, Geographic];
    return geodesic.Inverse(a.lat, a.lon, b.lat, b.lon).s12!;
  },
  along(from, to, count) {
    const [a, b] = [from, to] as [Geographic, Geographic];
    const line = geodesic.InverseLine(a.lat, a.lon, b.lat, b.lon);
    return Array.from({ length: count }, (_, i) => {
      const { lat2, lon2 } = line.Position((line.s13 * i) / (count - 1));
      return { lat: lat2!, lon: lon2! };
    });
  },
  area(ring) {
    const polygon = geodesic.Polygon(false);
    for (const place of ring as Geographic[]) polygon.AddPoint(place.lat, place.lon);
    return Math.abs(polygon.Compute(false, true).area!);
  },
  offset(from, east_m, north_m) {
    const { lat, lon } = from as Geographic;
    const { lat2, lon2 } = geodesic.Direct(lat, lon, (Math.atan2(east_m, north_m) * 180) / Math.PI, Math.hypot(east_m, north_m));
    return { lat: lat2!, lon: lon2! };
  },
  towards(from, to) {
    const [a, b] = [from, to] as [Geographic, Geographic];
    const { s12, azi1 } = geodesic.Inverse(a.lat, a.lon, b.lat, b.lon), azimuth = (azi1! * Math.PI) / 180;
    return [s12! * Math.sin(azimuth), s12! * Math.cos(azimuth)];
  },
});
const kEllipsoid = onEllipsoid(WGS84);

const kMap: Earth = {
  distance(from, to) {
    const [a, b] = [from, to] as [Projected, Projected];
    return Math.hypot(b.easting - a.easting, b.northing - a.northing);
  },
  along(from, to, count) {
    const [a, b] = [from, to] as [Projected, Projected];
    return Array.from({ length: count }, (_, i) => {
      const t = i / (count - 1);
      return { easting: a.easting + t * (b.easting - a.easting), northing: a.northing + t * (b.northing - a.northing) };
    });
  },
  area(ring) {
    const [first, ...rest] = ring as Projected[];
    let twice = 0;
    rest.forEach((a, i) => {
      const b = rest[i + 1] ?? first!;
      twice += (a.easting - first!.easting) * (b.northing - first!.northing) - (b.easting - first!.easting) * (a.northing - first!.northing);
    });
    return Math.abs(twice) / 2;
  },
  offset(from, east_m, north_m) {
    const { easting, northing } = from as Projected;
    return { easting: easting + east_m, northing: northing + north_m };
  },
  towards(from, to) {
    const [a, b] = [from, to] as [Projected, Projected];
    return [b.easting - a.easting, b.northing - a.northing];
  },
};
