// When to draw again after the graphics card was reset: at once, and after growing waits where it is reset, or cannot be had, again and
// again.
const kFirstWait_ms = 500;
const kLongestWait_ms = 8000;
const kCalm_ms = 30_000; // after so long without a reset the next one is a first one

export class Comeback {
  private last_ms = -Infinity;
  private wait_ms = 0;

  // How long to wait before the next attempt.
  next(now_ms: number): number {
    const is_first = now_ms - this.last_ms > kCalm_ms;
    this.wait_ms = is_first ? 0 : Math.min(Math.max(kFirstWait_ms, 2 * this.wait_ms), kLongestWait_ms);
    this.last_ms = now_ms + this.wait_ms;
    return this.wait_ms;
  }
}
