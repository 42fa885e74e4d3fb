// Marks of an overlay's points: pins that stand on the ground, and are hidden by what lies in front of them.
import type { Vector } from '@foreland/client';
import type { At } from '../cut/ring';
import { isKept, type Kept } from '../cut/spans';
import * as THREE from 'three';
import type { Feature } from '../overlay/feature';
import { drawPin } from './pins';
import { kMarkFragment, kMarkVertex, shader } from './shaders';

const kTile = 128; // texels of a pin's picture
const kAcross = 8; // pictures: mark.frag.glsl
const kWide = 0.72; // of a pin's height

export interface Mark {
  point: Vector; // in the scene's axes
  lattice: At;
  feature: Feature;
}

export class OverlayMarks {
  readonly object: THREE.Points;
  private given: readonly Mark[] = [];
  private cut_away: Kept | null = null;
  private readonly uniforms = { u_pins: { value: new THREE.Texture() }, u_ratio: { value: 1 } };

  constructor() {
    const material = Object.assign(shader(kMarkVertex, kMarkFragment, this.uniforms), { transparent: true, depthWrite: false, premultipliedAlpha: true });
    this.object = Object.assign(new THREE.Points(new THREE.BufferGeometry(), material), { frustumCulled: false, visible: false, renderOrder: 9 });
    this.object.onBeforeRender = (renderer) => void (this.uniforms.u_ratio.value = renderer.getPixelRatio());
  }

  show(marks: readonly Mark[]): void {
    this.given = marks;
    this.draw(marks.filter((mark) => this.isDrawn(mark)));
  }
  // Those on what it takes away are left out. Null: none.
  cut(cut: Kept | null): void {
    this.cut_away = cut;
    if (this.given.length > 0) this.show(this.given);
  }
  private isDrawn({ lattice }: Mark): boolean {
    return this.cut_away === null || isKept(this.cut_away, lattice);
  }

  // Counted from the first one on, so that floats are exact enough far from the scene's origin.
  private draw(marks: readonly Mark[]): void {
    const { object } = this, first = marks[0]?.point;
    object.visible = first !== undefined;
    object.geometry.dispose();
    object.geometry = new THREE.BufferGeometry();
    if (!first) return;
    const symbols = [...new Set(['', ...marks.map(({ feature }) => feature.style.symbol)])].slice(0, kAcross ** 2);
    const tileOf = new Map(symbols.map((symbol, i) => [symbol, i]));
    const flat = (count: number, numbersOf: (mark: Mark) => readonly number[]) => new THREE.Float32BufferAttribute(marks.flatMap((mark) => [...numbersOf(mark)]), count);
    object.position.fromArray(first);
    object.geometry.setAttribute('position', flat(3, ({ point }) => point.map((v, i) => v - first[i]!)));
    object.geometry.setAttribute('color', flat(3, ({ feature }) => feature.style.marker));
    object.geometry.setAttribute('mark', flat(2, ({ feature: { style } }) => [style.marker_px, tileOf.get(style.symbol) ?? 0]));
    this.uniforms.u_pins.value.dispose();
    this.uniforms.u_pins.value = picturesOf(symbols);
  }

  // The nearest to the eye of the marks that are seen at a point of the window.
  markAt(marks: readonly Mark[], x: number, y: number, onScreen: (point: Vector) => Vector | null, isSeen: (point: Vector) => boolean): Mark | null {
    const [found] = marks.filter((mark) => this.isDrawn(mark)).flatMap((mark) => {
      const at = onScreen(mark.point), { marker_px } = mark.feature.style;
      return at && Math.abs(x - at[0]) <= (kWide / 2) * marker_px && y <= at[1] + 2 && y >= at[1] - marker_px ? [{ mark, depth: at[2] }] : [];
    }).sort((a, b) => a.depth - b.depth).filter(({ mark }) => isSeen(mark.point));
    return found?.mark ?? null;
  }

  dispose(): void {
    this.object.geometry.dispose();
    this.uniforms.u_pins.value.dispose();
  }
}

function picturesOf(symbols: readonly string[]): THREE.Texture {
  const canvas = Object.assign(document.createElement('canvas'), { width: kAcross * kTile, height: kAcross * kTile });
  const context = canvas.getContext('2d')!;
  symbols.forEach((symbol, i) => {
    context.setTransform(1, 0, 0, 1, (i % kAcross) * kTile, Math.floor(i / kAcross) * kTile);
    drawPin(context, kTile, symbol);
  });
  return Object.assign(new THREE.CanvasTexture(canvas), { flipY: false, premultiplyAlpha: true });
}
