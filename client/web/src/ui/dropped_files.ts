// Files that are dropped on the page, or opened by an input. Each goes to the first reader that takes its name.
import { reasonOf } from './words';

export interface NamedReader {
  names: RegExp;
  max_bytes: number;
  read(name: string, bytes: Uint8Array<ArrayBuffer>): void | Promise<void>; // an Error says what is wrong
  refuse(name: string, reason: string): void;
}

export class DroppedFiles {
  constructor(private readonly readers: readonly NamedReader[], private readonly onUnknown: (name: string) => void) {
    window.addEventListener('dragover', (event) => event.preventDefault());
    window.addEventListener('drop', (event) => {
      event.preventDefault();
      for (const file of event.dataTransfer?.files ?? []) void this.take(file);
    });
  }

  // Takes what is opened with an input as well.
  listen(input: HTMLInputElement): void {
    input.onchange = () => {
      for (const file of input.files ?? []) void this.take(file);
      input.value = '';
    };
  }

  async take(file: File): Promise<void> {
    const reader = this.readers.find(({ names }) => names.test(file.name));
    if (!reader) return this.onUnknown(file.name);
    try {
      if (file.size > reader.max_bytes) throw new Error(`${file.name} has more than ${reader.max_bytes >> 20} MB.`);
      await reader.read(file.name, new Uint8Array(await bytesOf(file)));
    } catch (error) {
      reader.refuse(file.name, reasonOf(error));
    }
  }
}

// A file may be gone since it was chosen.
async function bytesOf(file: File): Promise<ArrayBuffer> {
  try {
    return await file.arrayBuffer();
  } catch (error) {
    throw new Error(`${file.name} cannot be read: ${reasonOf(error)}`);
  }
}
