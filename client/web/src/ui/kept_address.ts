// Keeps the view in the page's address, so that the page can be loaded again, and shared, where the camera is. The address changes a few
// times a second at most: Safari refuses more than a hundred changes in 30 s. What the page was opened with stays until the view changes.
import type { Look } from './camera';

const kPause_ms = 500;

export class KeptAddress {
  private last = '';
  private last_ms = -Infinity;
  private is_refused = false; // in a frame whose address is not its own, say

  // `write` puts a query into the page's address.
  constructor(private readonly write: (query: string) => void) {}

  // The address says this already.
  begin(query: string): void {
    this.last = query;
  }

  // With each frame.
  keep(now_ms: number, queryOf: () => string): void {
    if (this.is_refused || now_ms - this.last_ms < kPause_ms) return;
    const query = queryOf();
    if (query === this.last) return;
    [this.last, this.last_ms] = [query, now_ms];
    try {
      this.write(query);
    } catch {
      this.is_refused = true;
    }
  }
}

// `view=` of an eye and a look in a scene of an extent: fine enough that nobody sees the difference.
export function viewText(eye: readonly number[], { heading, pitch }: Look, extent_m: number): string {
  const decimals = Math.min(Math.max(5 - Math.floor(Math.log10(extent_m)), 1), 6);
  const turn = 2 * Math.PI;
  const angles = [heading - turn * Math.round(heading / turn), pitch].map((angle) => ((angle * 180) / Math.PI).toFixed(3));
  return [...eye.map((metres) => metres.toFixed(decimals)), ...angles].map((number) => number.replace(/^-(0(\.0*)?)$/, '$1')).join(',');
}

// As it can be read in the address.
export function queryText(query: URLSearchParams): string {
  const text = query.toString().replaceAll('%2C', ',').replaceAll('%3A', ':').replaceAll('%2F', '/');
  return text === '' ? '' : `?${text}`;
}
