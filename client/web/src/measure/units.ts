// Lengths and areas in words, metric or imperial.
export type Units = 'metric' | 'imperial';

const kFoot_m = 0.3048, kMile_m = 1609.344, kAcre_m2 = 4046.8564224;

function digits(value: number, unit: string): string {
  const size = Math.abs(value);
  return `${value.toLocaleString('en', { maximumFractionDigits: size < 10 ? 2 : size < 1000 ? 1 : 0 })} ${unit}`;
}

export function lengthText(metres: number, units: Units): string {
  const size = Math.abs(metres);
  if (units === 'metric') return size < 1000 ? digits(metres, 'm') : digits(metres / 1000, 'km');
  return size < kMile_m ? digits(metres / kFoot_m, 'ft') : digits(metres / kMile_m, 'mi');
}
// Heights stay in the small unit.
export function heightText(metres: number, units: Units): string {
  return units === 'metric' ? digits(metres, 'm') : digits(metres / kFoot_m, 'ft');
}
export function areaText(m2: number, units: Units): string {
  if (units === 'metric') return m2 < 1e4 ? digits(m2, 'm\u00b2') : m2 < 1e6 ? digits(m2 / 1e4, 'ha') : digits(m2 / 1e6, 'km\u00b2');
  return m2 < kAcre_m2 ? digits(m2 / kFoot_m ** 2, 'ft\u00b2') : m2 < kMile_m ** 2 ? digits(m2 / kAcre_m2, 'ac') : digits(m2 / kMile_m ** 2, 'mi\u00b2');
}
export function volumeText(m3: number, units: Units): string {
  return units === 'metric' ? (m3 < 1e6 ? digits(m3, 'm\u00b3') : digits(m3 / 1e6, 'million m\u00b3')) : digits(m3 / (3 * kFoot_m) ** 3, 'yd\u00b3');
}
