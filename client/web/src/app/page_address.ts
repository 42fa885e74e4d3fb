// The page's address as it would lead here: with where the camera is, and without a tour that has ended.
import type { Scene } from '@foreland/client';
import type { Controls } from '../ui/controls';
import { queryText, viewText } from '../ui/kept_address';

export function addressHere(scene: Scene | null, { eye, look }: Controls, is_touring: boolean): URLSearchParams {
  const query = new URLSearchParams(window.location.search);
  if (!scene) return query;
  const { low, high } = scene.bounds;
  query.set('view', viewText(eye.toArray(), look, Math.hypot(high[0] - low[0], high[1] - low[1])));
  if (!is_touring) query.delete('tour');
  return query;
}

export function writeQuery(query: string): void {
  window.history.replaceState(window.history.state, '', `${window.location.pathname}${query}${window.location.hash}`);
}

export function reloadAt(query: URLSearchParams): void {
  writeQuery(queryText(query));
  window.location.reload();
}
