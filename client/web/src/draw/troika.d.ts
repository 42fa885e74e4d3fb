// What the page uses of troika-three-text, which has no types of its own for bundlers.
declare module 'troika-three-text' {
  import type { Material, Mesh } from 'three';
  export class Text extends Mesh {
    material: Material | Material[];
    textRenderInfo: { blockBounds: readonly number[] } | null;
    sync(onDone?: () => void): void;
    dispose(): void;
  }
  export function configureTextBuilder(options: { useWorker: boolean; defaultFontURL: string }): void;
}
