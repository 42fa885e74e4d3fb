// Which files the page takes, dropped or opened, and what becomes of each.
import { kOverlayFiles, kOverlayKinds } from '../overlay/file_kinds';
import { inWorker } from '../overlay/in_worker';
import { kColourFiles } from '../ui/colour_maps';
import { DroppedFiles } from '../ui/dropped_files';
import { reasonOf } from '../ui/words';
import { kNotLaid, type Tools } from './tools';

export interface Takers {
  tools: Pick<Tools, 'overlays' | 'follow' | 'waypoints'>;
  addColours(name: string, text: string): void;
  refuse(title: string, reason: string): void;
}

export function takeFiles({ tools: { overlays, follow, waypoints }, addColours, refuse }: Takers): DroppedFiles {
  return new DroppedFiles([
    { ...kColourFiles, read: (name, bytes) => addColours(name.replace(/\.cpt$/i, ''), new TextDecoder().decode(bytes)),
      refuse: (_, reason) => refuse('This colour map cannot be read', reason) },
    { ...kOverlayFiles, read: async (name, bytes) => {
      await overlays.add(name, bytes);
      const { json } = await inWorker('track', { name, bytes });
      if (json && !waypoints.take(json)) await follow.take(name, json, !/\.gpx$/i.test(name));
    }, refuse: (_, reason) => refuse(kNotLaid, reason) },
  ], (name) => refuse('This file says nothing to the page', `${name} is no colour map (.cpt), and no ${kOverlayKinds}.`));
}

// Files that the page's address names, by addresses that count from the page's own.
export async function takeAddressed(files: DroppedFiles, addresses: readonly string[], refuse: Takers['refuse']): Promise<void> {
  for (const address of addresses) {
    try {
      const url = new URL(address, window.location.href), answer = await fetch(url);
      if (!answer.ok) throw new Error(`The server answers ${answer.status}.`);
      await files.take(new File([await answer.blob()], decodeURIComponent(url.pathname.split('/').pop()!)));
    } catch (error) {
      refuse(`${address} does not come`, reasonOf(error));
    }
  }
}
