// Who is flown, at which qualities, and what a quality costs.
import { cutQuantizedMesh, cutTerrainRgb } from './cut_tiles.mjs';

// `qualities` in pixels of the lens, by each one's own measure.
export const kRivals = {
  cesium: { page: 'cesium', cut: cutQuantizedMesh, qualities: [1, 2, 4, 8] },
  maplibre: { page: 'maplibre', cut: cutTerrainRgb, qualities: [0.5, 1, 2, 4] },
  '3d-tiles': { page: 'tiles3d', cut: cutQuantizedMesh, qualities: [1, 2, 4, 8] },
};

// Bytes of a rival over ours at our root mean square error: between the two qualities whose errors are about it, along a line of
// the logarithms. Null where none is; then `nearest_rms_px` says how near the best quality came, at `nearest_over_foreland` times our bytes.
export function overForeland(flights, ours) {
  const sorted = flights.filter(({ rms_px }) => rms_px > 0).sort((a, b) => a.rms_px - b.rms_px);
  const nearest = sorted.reduce((best, one) => (best && Math.abs(Math.log(best.rms_px / ours.rms_px)) <= Math.abs(Math.log(one.rms_px / ours.rms_px)) ? best : one), null);
  const said = { bytes_over_foreland: null, nearest_rms_px: nearest?.rms_px ?? null, nearest_over_foreland: nearest ? nearest.bytes / ours.bytes : null };
  for (let i = 1; i < sorted.length; ++i) {
    const [fine, coarse] = [sorted[i - 1], sorted[i]];
    if (fine.rms_px > ours.rms_px || coarse.rms_px < ours.rms_px) continue;
    const share = coarse.rms_px === fine.rms_px ? 0 : Math.log(ours.rms_px / fine.rms_px) / Math.log(coarse.rms_px / fine.rms_px);
    return { ...said, bytes_over_foreland: Math.exp(Math.log(fine.bytes) * (1 - share) + Math.log(coarse.bytes) * share) / ours.bytes };
  }
  return said;
}
