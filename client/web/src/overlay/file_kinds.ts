// Which files lie on the ground, and how large they may be.
const kMebi = 1 << 20;

export const kOverlayFiles = { names: /\.(geojson|json|kml|kmz|gpx|igc|csv|tsv)$/i, max_bytes: 64 * kMebi };
export const kMaxXmlCharacters = 16 * kMebi; // a tree of them takes about fifty times as much
export const kOverlayKinds = 'GeoJSON, KML, KMZ, GPX, IGC or CSV';
