// A viewshed laid over the terrain: green where the ground is seen, darker where it is hidden, as it was elsewhere.
import * as THREE from 'three';
import type { Viewshed } from '../core/sight';

export class ViewshedDrape {
  readonly uniforms: Record<string, THREE.IUniform>;
  private viewshed: Viewshed | null = null;
  private texture = textureOf(1, 1, new Uint8Array([2]));

  constructor() {
    this.uniforms = {
      u_viewshed: { value: this.texture },
      u_viewshed_place: { value: new THREE.Vector4(0, 0, 1, 1) }, // the first cell's middle from the pivot; the step
    };
  }

  // What is known of a viewshed so far; null: none.
  show(viewshed: Viewshed | null): void {
    if (viewshed && viewshed === this.viewshed) {
      this.texture.needsUpdate = true;
      return;
    }
    this.viewshed = viewshed;
    this.texture.dispose();
    this.texture = viewshed ? textureOf(viewshed.columns, viewshed.rows, viewshed.cells) : textureOf(1, 1, new Uint8Array([2]));
    this.uniforms.u_viewshed!.value = this.texture;
  }

  // The frame's pivot on the lattice, from which the shader counts positions.
  place(pivot: THREE.Vector2): void {
    if (!this.viewshed) return;
    const { first, step } = this.viewshed;
    (this.uniforms.u_viewshed_place!.value as THREE.Vector4).set(first[0] - pivot.x, first[1] - pivot.y, step[0], step[1]);
  }
}

function textureOf(columns: number, rows: number, cells: Uint8Array<ArrayBuffer>): THREE.DataTexture {
  const texture = new THREE.DataTexture(cells, columns, rows, THREE.RedFormat);
  Object.assign(texture, { unpackAlignment: 1, needsUpdate: true });
  return texture;
}
