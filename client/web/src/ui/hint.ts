// Text over the scene that goes by itself: how to fly, and what is amiss but ends nothing. Lines end where the text says.
const kShown_ms = 9000;

export class Hint {
  private timer = 0;

  constructor(private readonly root: HTMLElement) {}

  show(text: string): void {
    this.root.textContent = text;
    this.root.classList.remove('gone');
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.root.classList.add('gone'), kShown_ms);
  }
}
