// Questions for exact ground, one at a time: a server refuses a viewer that asks for more than it reads. One that is under way as a
// connection is lost is asked again on the next.
import type { ExactGround } from '../core/messages.js';

interface Question {
  id: number;
  positions: Float64Array;
}

export class GroundQueue {
  private readonly waiting: Question[] = [];
  private asked: number | null = null; // the request's id of the first of them; who else asks takes its own replies

  // `send` sends lattice positions and gives the id of the reply, or null while there is no session.
  constructor(private readonly send: (positions: Float64Array) => number | null,
              private readonly onReply: (id: number, ground: ExactGround) => void) {}

  get request(): number | null {
    return this.asked;
  }
  ask(id: number, positions: Float64Array): void {
    this.waiting.push({ id, positions });
    this.askNext();
  }
  // On a new connection.
  askAgain(): void {
    this.asked = null;
    this.askNext();
  }
  take(request: number, ground: ExactGround): void {
    if (request !== this.asked) return;
    this.asked = null;
    this.onReply(this.waiting.shift()!.id, ground);
    this.askNext();
  }

  private askNext(): void {
    const [first] = this.waiting;
    if (first && this.asked === null) this.asked = this.send(first.positions);
  }
}
