// A viewshed laid over the terrain: green where the ground is seen, darker where it is hidden, as it was elsewhere.
import type { Viewshed } from '@foreland/client';
import * as THREE from 'three';

const kNone = new Uint8Array([2]); // one cell of which nothing is known

export class ViewshedDrape {
  readonly uniforms = {
    u_viewshed: { value: textureOf(1, 1, kNone) },
    u_viewshed_place: { value: new THREE.Vector4(0, 0, 1, 1) }, // the first cell's middle from the pivot; the step
  };
  private viewshed: Viewshed | null = null;

  // What is known of a viewshed so far; null: none.
  show(viewshed: Viewshed | null): void {
    const { u_viewshed } = this.uniforms;
    if (viewshed === this.viewshed) {
      u_viewshed.value.needsUpdate = true;
      return;
    }
    this.viewshed = viewshed;
    u_viewshed.value.dispose();
    u_viewshed.value = viewshed ? textureOf(viewshed.columns, viewshed.rows, viewshed.cells) : textureOf(1, 1, kNone);
  }

  // The frame's pivot on the lattice, from which the shader counts positions.
  place(pivot: THREE.Vector2): void {
    if (!this.viewshed) return;
    const { first, step } = this.viewshed;
    this.uniforms.u_viewshed_place.value.set(first[0] - pivot.x, first[1] - pivot.y, ...step);
  }
}

function textureOf(columns: number, rows: number, cells: Uint8Array<ArrayBuffer>): THREE.DataTexture {
  const texture = new THREE.DataTexture(cells, columns, rows, THREE.RedFormat);
  return Object.assign(texture, { unpackAlignment: 1, needsUpdate: true });
}
