// What is done when the graphics card is reset: the page says so, and waits until the browser can draw again.
import { canDraw } from '../draw/can_draw';
import { Comeback } from '../draw/comeback';

export class CardLoss {
  private readonly comeback = new Comeback();
  private timer = 0;

  // `run` runs the page's work, `drawAgain` makes another picture.
  constructor(private readonly run: (work: () => void) => void, private readonly drawAgain: () => void) {}

  wait(): void {
    const wait_ms = this.comeback.next(performance.now());
    this.timer = window.setTimeout(() => this.run(() => (canDraw() ? this.drawAgain() : this.wait())), wait_ms);
  }
  end(): void {
    window.clearTimeout(this.timer);
  }
}
