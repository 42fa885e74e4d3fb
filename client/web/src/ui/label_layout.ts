// Which labels are shown: those that are seen, the more important first, and no two that overlap. What is shown stays so: a label comes after
// it could have been there for a while, and goes at once only where another one needs its place. Pure but for its memory.

export const kSteady_ms = 300; // after which a change is believed
const kMargin_px = 8; // about a label that comes, so that it is not in the way at once
export const kMostShown = 60;

export interface LabelCandidate {
  id: number;
  box: readonly [left: number, top: number, right: number, bottom: number]; // px of the window
  importance: number; // the lower the more
  depth: number; // m
  is_seen: boolean; // from the eye
}

interface Memory {
  is_shown: boolean;
  since_ms: number;
  other_ms: number | null; // since when it should be the other way
}

export class LabelLayout {
  private memory = new Map<number, Memory>();

  // Those of the candidates that are shown. Labels that are no candidates any more, as they have left the window, are gone.
  update(now_ms: number, candidates: readonly LabelCandidate[]): Set<number> {
    const before = this.memory, memory = (this.memory = new Map<number, Memory>()), placed: LabelCandidate['box'][] = [];
    const wasShown = ({ id }: LabelCandidate) => Number(before.get(id)?.is_shown ?? false);
    const sorted = [...candidates].sort((a, b) => a.importance - b.importance || wasShown(b) - wasShown(a) || a.depth - b.depth || a.id - b.id);
    const shown = new Set<number>();
    for (const { id, box, is_seen } of sorted) {
      const is_taken = placed.some((other) => overlap(box, other, 0)), last = before.get(id) ?? { is_shown: false, since_ms: -Infinity, other_ms: null };
      const is_free = !is_taken && placed.length < kMostShown && (last.is_shown || !placed.some((other) => overlap(box, other, kMargin_px)));
      const next = last.is_shown && is_taken ? { is_shown: false, since_ms: now_ms, other_ms: null } : stepped(last, is_seen && is_free, now_ms);
      memory.set(id, next);
      if (!next.is_shown) continue;
      shown.add(id);
      placed.push(box);
    }
    return shown;
  }
  clear(): void {
    this.memory.clear();
  }
}

function stepped(last: Memory, wanted: boolean, now_ms: number): Memory {
  if (wanted === last.is_shown) return { ...last, other_ms: null };
  const other_ms = last.other_ms ?? now_ms;
  const is_due = now_ms - Math.max(other_ms, last.since_ms) >= kSteady_ms;
  return is_due ? { is_shown: wanted, since_ms: now_ms, other_ms: null } : { ...last, other_ms };
}

function overlap(a: LabelCandidate['box'], b: LabelCandidate['box'], margin: number): boolean {
  return a[0] < b[2] + margin && b[0] < a[2] + margin && a[1] < b[3] + margin && b[1] < a[3] + margin;
}
