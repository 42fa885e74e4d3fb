// What controls by hand need of the page, and which clicks and keys are for them.
import type { Terrain } from '@foreland/client';
import type { Picture } from '../draw/picture';

const kClick_px = 4; // a pointer that moves farther drags

export interface Stage {
  picture(): Picture;
  terrain(): Terrain | null;
  sceneTime(): number; // ms
  say(text: string): void;
}

// Calls `run` with clicks on the picture.
export function onClicks(stage: Stage, run: (event: MouseEvent) => void): void {
  let pressed: [number, number] = [0, 0];
  window.addEventListener('pointerdown', (event) => (pressed = [event.clientX, event.clientY]));
  window.addEventListener('click', (event) => {
    const moved = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]);
    if (moved <= kClick_px && stage.picture().isOn(event.target)) run(event);
  });
}

// Whether a key is the page's: neither typed into a control nor the browser's own.
export function isForPage(event: KeyboardEvent): boolean {
  return !isIn(event, /^(INPUT|SELECT|TEXTAREA)$/) && !event.ctrlKey && !event.metaKey && !event.altKey;
}
export function isOnButton(event: KeyboardEvent): boolean {
  return isIn(event, /^BUTTON$/);
}
function isIn(event: KeyboardEvent, tags: RegExp): boolean {
  return event.target instanceof HTMLElement && tags.test(event.target.tagName);
}
