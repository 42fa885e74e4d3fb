// Who is flown, at which qualities, and what a quality costs.
import { cutQuantizedMesh, cutTerrainRgb } from './cut_tiles.mjs';

// `qualities` in pixels of the lens, by each one's own measure.
export const kRivals = {
  cesium: { page: 'cesium', cut: cutQuantizedMesh, qualities: [1, 2, 4, 8] },
  maplibre: { page: 'maplibre', cut: cutTerrainRgb, qualities: [0.5, 1, 2, 4] },
  '3d-tiles': { page: 'tiles3d', cut: cutQuantizedMesh, qualities: [1, 2, 4, 8] },
};

// Bytes at a root mean square error: between the two flights whose errors are about it, along a line of the logarithms. Null where there
// are no such two.
export function bytesAt(flights, rms_px) {
  const sorted = flights.filter((flight) => flight.rms_px > 0).sort((a, b) => a.rms_px - b.rms_px);
  for (let i = 1; i < sorted.length; ++i) {
    const [fine, coarse] = [sorted[i - 1], sorted[i]];
    if (fine.rms_px > rms_px || coarse.rms_px < rms_px) continue;
    const share = coarse.rms_px === fine.rms_px ? 0 : Math.log(rms_px / fine.rms_px) / Math.log(coarse.rms_px / fine.rms_px);
    return Math.exp(Math.log(fine.bytes) * (1 - share) + Math.log(coarse.bytes) * share);
  }
  return null;
}

const best = (flights) => flights.reduce((least, flight) => (least && least.rms_px <= flight.rms_px ? least : flight), null);

// The tolerance at which our error ought to be above the least that a rival has, where none of ours is; otherwise null.
export function coarserTolerance(flights, ours) {
  const theirs = best(flights).rms_px, coarsest = ours.reduce((most, flight) => (flight.rms_px > most.rms_px ? flight : most));
  return theirs > coarsest.rms_px ? (1.5 * coarsest.quality * theirs) / coarsest.rms_px : null;
}

// Bytes of a rival over ours at equal error: at our least one, where a rival comes down to it; otherwise at the rival's least, with us at
// tolerances so much coarser. Null where neither has flights about the other's.
export function overForeland(flights, ours) {
  const [theirs, own] = [best(flights), best(ours)], at_ours = bytesAt(flights, own.rms_px), at_theirs = bytesAt(ours, theirs.rms_px);
  if (at_ours !== null) return { bytes_over_foreland: at_ours / own.bytes, at_rms_px: own.rms_px };
  return at_theirs === null ? { bytes_over_foreland: null, at_rms_px: null } : { bytes_over_foreland: theirs.bytes / at_theirs, at_rms_px: theirs.rms_px };
}
