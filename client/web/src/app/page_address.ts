// The page's address as it would lead here: with where the camera is and how it is shown, and without a tour that has ended.
import type { Terrain } from '@foreland/client';
import type { Controls } from '../ui/controls';
import { queryText, viewText } from '../ui/kept_address';
import { atText } from '../globe/place_text';
import { writeSettings, type Settings } from '../ui/settings';

export function addressHere(terrain: Terrain | null, { eye, look }: Controls, settings: Settings, is_touring: boolean): URLSearchParams {
  const query = new URLSearchParams(window.location.search);
  if (!terrain?.hasScene) return query;
  const { frame, bounds: { low, high } } = terrain.scene, place = terrain.toGeodetic(eye.toArray());
  if (frame === 'globe' && 'lat' in place) query.set('at', atText(place, look));
  else query.set('view', viewText(eye.toArray(), look, Math.hypot(high[0] - low[0], high[1] - low[1])));
  query.delete(frame === 'globe' ? 'view' : 'at');
  if (terrain.area === null) query.delete('area');
  else query.set('area', String(terrain.area));
  if (!is_touring) query.delete('tour');
  writeSettings(query, settings);
  return query;
}

// To give away: without what only this visit wants, and without the token of whoever gives it.
export function linkOf(query: URLSearchParams): string {
  const shared = new URLSearchParams(query);
  for (const own of ['record', 'lang']) shared.delete(own);
  return new URL(`${window.location.pathname}${queryText(shared)}`, window.location.href).href;
}

export function writeQuery(query: string): void {
  window.history.replaceState(window.history.state, '', `${window.location.pathname}${query}${window.location.hash}`);
}

export function reloadAt(query: URLSearchParams): void {
  writeQuery(queryText(query));
  window.location.reload();
}
