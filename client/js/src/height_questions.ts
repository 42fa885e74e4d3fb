// Questions for exact heights that wait for the server's answer.
import type { ExactGround } from './core/messages.js';
import { ForelandError } from './errors.js';

const kMaxPoints = 65_536; // of a question; proto/message/control.h

interface Question {
  resolve(ground: ExactGround): void;
  reject(error: ForelandError): void;
}

/** @internal */
export class HeightQuestions {
  private readonly waiting = new Map<number, Question>();
  private next = 1;

  // `ask` hands lattice positions, x and y each, to the worker.
  constructor(private readonly tell: (id: number, positions: Float64Array) => void) {}

  static check(count: number): void {
    if (count > kMaxPoints) throw new ForelandError('argument', `${count} places are too many for one question.`, `Ask for at most ${kMaxPoints}.`);
  }
  ask(at: readonly (readonly [number, number])[]): Promise<ExactGround> {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.tell(id, Float64Array.from(at.flat()));
    });
  }
  answer(id: number, ground: ExactGround): void {
    this.waiting.get(id)?.resolve(ground);
    this.waiting.delete(id);
  }
  end(error: ForelandError): void {
    for (const question of this.waiting.values()) question.reject(error);
    this.waiting.clear();
  }
}
