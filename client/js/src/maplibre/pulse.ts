// When a map is to be drawn again, which draws only if it is asked to: at once while what is drawn changes, and now and then at rest, for
// meshes and tiles that come.
const kRests = 30; // pictures that were the same
const kSlow_ms = 250;

/** @internal */
export class Pulse {
  private last = '';
  private same = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private repaint: () => void) {}

  // After a picture; `drawn` tells it apart from others.
  beat(drawn: string): void {
    this.same = drawn === this.last ? this.same + 1 : 0;
    this.last = drawn;
    clearTimeout(this.timer);
    if (this.same < kRests) this.repaint();
    else this.timer = setTimeout(() => this.repaint(), kSlow_ms);
  }
  end(): void {
    clearTimeout(this.timer);
    this.repaint = () => {};
  }
}
