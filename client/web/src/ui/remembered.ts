// What this browser remembers of a person's choices, between visits. Where it keeps nothing (a private window, storage that is switched
// off), each visit is the first.
const kPrefix = 'foreland.';

export function isRemembered(name: string): boolean {
  try {
    return window.localStorage.getItem(kPrefix + name) === '1';
  } catch {
    return false;
  }
}

export function remember(name: string, is_so: boolean): void {
  try {
    if (is_so) window.localStorage.setItem(kPrefix + name, '1');
    else window.localStorage.removeItem(kPrefix + name);
  } catch {
    // It is asked again next time.
  }
}
