// What can go wrong, as errors that say what to do.
import type { Failure } from './core/failure.js';
import { sentenceOf } from './core/refusal.js';

/**
 * What kind of thing went wrong:
 * - `address`: the address of the server is no address;
 * - `unreachable`: no session began in the time that `open` was given;
 * - `refused`: the server ended the session, or does not let this viewer in;
 * - `unsupported`: this browser lacks what the client needs;
 * - `module`: foreland.wasm did not load;
 * - `start`: the client core did not start, as where memory is short;
 * - `worker`: the worker's script did not load;
 * - `core`: the client core failed in flight;
 * - `client`: something else failed;
 * - `unanswered`: the server has no answer to a question of what is seen, or it was lost with the connection;
 * - `closed`: the terrain has been closed;
 * - `argument`: what was asked for makes no sense.
 */
export type ErrorCode = 'address' | 'unreachable' | 'refused' | 'unsupported' | 'module' | 'start' | 'worker' | 'core' | 'client' | 'unanswered' | 'closed' | 'argument';

/** Every error of this package. `message` says what happened, `advice` what to do about it; both are sentences. */
export class ForelandError extends Error {
  override readonly name = 'ForelandError';

  /** `reason` is what the browser or the server said, if it said anything. */
  constructor(readonly code: ErrorCode, message: string, readonly advice = '', options?: ErrorOptions, readonly reason = message) {
    super(message, options);
  }
}

const kFailures = {
  'core start': { code: 'start', title: 'The client core did not start.', advice: 'If memory is short, close other terrains and pages, and open this one again.' },
  'core': { code: 'core', title: 'The client core failed.', advice: 'Close this terrain and open it again; the console tells more.' },
  'worker start': { code: 'worker', title: 'The worker did not load.', advice: 'Serve worker.js beside the package, pass its address as `worker`, or import @foreland/client/inline.' },
  'page': { code: 'client', title: 'The client failed.', advice: 'Close this terrain and open it again; the console tells more.' },
} as const;

/** @internal */
export function errorOf({ part, reason }: Failure): ForelandError {
  const { code, title, advice } = kFailures[part];
  return new ForelandError(code, reason === '' ? title : `${title} ${sentenceOf(reason)}`, advice, {}, reason);
}
