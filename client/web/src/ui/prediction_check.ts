// How far a keyframe's predicted eye was from where the eye really was when the keyframe's time came.

export class PredictionCheck {
  error_m: number | null = null;
  private readonly expected: { at_ms: number; eye: readonly number[] }[] = [];
  private last: { at_ms: number; eye: readonly number[] } | null = null;

  expect(at_ms: number, eye: readonly number[]): void {
    if (this.expected.some((e) => e.at_ms === at_ms)) return;
    this.expected.push({ at_ms, eye });
    if (this.expected.length > 16) this.expected.shift();
  }

  // The eye at a frame; between two frames it is taken to move straight.
  frame(now_ms: number, eye: readonly number[]): void {
    const last = this.last;
    this.last = { at_ms: now_ms, eye };
    if (!last || last.at_ms >= now_ms) return;
    while (this.expected[0] && this.expected[0].at_ms <= now_ms) {
      const { at_ms, eye: guess } = this.expected.shift()!;
      if (at_ms < last.at_ms) continue;
      const weight = (at_ms - last.at_ms) / (now_ms - last.at_ms);
      this.error_m = Math.hypot(...guess.map((g, i) => g - (last.eye[i]! + weight * (eye[i]! - last.eye[i]!))));
    }
  }

  forget(): void {
    this.expected.length = 0;
    this.error_m = null;
  }
}
