// Why the page cannot go on, as its two threads tell each other; ui/failure_words.ts says it to a person.

// What failed: the client core as it was started, the client core in flight, the worker as it was loaded, or anything else.
export type FailedPart = 'core start' | 'core' | 'worker start' | 'page';

export interface Failure {
  part: FailedPart;
  reason: string; // the browser's words
}

// The client core did not start, or has stopped.
export class CoreError extends Error {
  constructor(readonly part: 'core start' | 'core', reason: string, options?: ErrorOptions) {
    super(reason, options);
  }
}

export function failureOf(error: unknown): Failure {
  const reason = reasonOf(error);
  if (error instanceof CoreError) return { part: error.part, reason };
  return { part: error instanceof WebAssembly.RuntimeError ? 'core' : 'page', reason };
}

export function reasonOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
