// Runs the page's work, which may fail. What has failed may be half changed, so nothing runs after the first failure. A failure is logged
// here, once, and told to whoever made the guard.
export class Guard {
  private is_over = false;

  constructor(private readonly onFailure: (error: unknown) => void) {}

  run(work: () => void): void {
    if (this.is_over) return;
    try {
      work();
    } catch (error) {
      this.is_over = true;
      console.error(error);
      this.onFailure(error);
    }
  }

  // Nothing runs any more, though nothing has failed here.
  end(): void {
    this.is_over = true;
  }
}
