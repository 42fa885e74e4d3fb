// Runs the work of a thread that may fail. What has failed may be half changed, so nothing runs after the first failure. A failure is
// logged here, once, and told to whoever made the guard.
export class Guard {
  private is_over = false;

  constructor(private readonly onFailure: (error: unknown) => void) {}

  // Whether nothing runs any more.
  get isOver(): boolean {
    return this.is_over;
  }

  run(work: () => void): void {
    if (this.is_over) return;
    try {
      work();
    } catch (error) {
      this.fail(error);
    }
  }

  // The same for work that takes its time. Never rejects.
  async runToEnd(work: () => Promise<void>): Promise<void> {
    if (this.is_over) return;
    await work().catch((error: unknown) => this.fail(error));
  }

  // Something has failed elsewhere.
  fail(error: unknown): void {
    if (this.is_over) return;
    this.is_over = true;
    console.error(error);
    this.onFailure(error);
  }

  // Nothing runs any more, though nothing has failed here.
  end(): void {
    this.is_over = true;
  }
}
