// Names over the ground, as signed-distance text of one size on the screen. The library that makes it, and its font, are fetched with the
// first name.
import * as THREE from 'three';
import type { Vector } from '@foreland/client';
import type { Text } from 'troika-three-text';
import { kLens } from '../ui/settings';

const kFont_px = 14;
const kGap_px = 3; // between a pin and its name
const kMostKept = 400;

export interface NameText {
  id: number;
  text: string;
  point: Vector; // in the scene's axes
  lift_px: number; // above that
}

type Troika = typeof import('troika-three-text');
let fetched: Promise<Troika> | null = null; // once for the page

interface Made extends NameText {
  object: Text;
  size: readonly [number, number] | null; // px; null before it is known
}

export class NameTexts {
  readonly object = new THREE.Group();
  private readonly made = new Map<number, Made>();
  private library: Troika | 'coming' | null = null;
  private shown: ReadonlySet<number> = new Set();

  constructor() {
    Object.assign(this.object, { renderOrder: 20 });
  }

  // Its size in pixels, once it is known: it is made if it is not there.
  sizeOf(name: NameText): Made['size'] {
    if (this.library === null) void this.fetchLibrary();
    if (this.library === null || this.library === 'coming') return null;
    const made = this.made.get(name.id) ?? this.make(this.library, name);
    return made.size;
  }
  show(ids: ReadonlySet<number>): void {
    this.shown = ids;
    for (const [id, { object }] of this.made) object.visible = ids.has(id);
    for (const [id] of this.made) {
      if (this.made.size <= kMostKept) break;
      if (!ids.has(id)) this.drop(id);
    }
  }
  clear(): void {
    for (const id of [...this.made.keys()]) this.drop(id);
  }

  // Upright before the camera, `height` pixels of the page high.
  place(camera: THREE.PerspectiveCamera, height: number): void {
    const per_depth = (2 * Math.tan(kLens.fov_rad / 2)) / height;
    for (const id of this.shown) {
      const made = this.made.get(id);
      if (!made) continue;
      const { object, point, lift_px } = made;
      kAt.fromArray(point).applyMatrix4(camera.matrixWorldInverse);
      const pixel = per_depth * Math.max(-kAt.z, 1e-6);
      kAt.y += (lift_px + kGap_px) * pixel;
      object.matrix.copy(camera.matrixWorld).scale(kScale.setScalar(kFont_px * pixel)).setPosition(kAt.applyMatrix4(camera.matrixWorld));
      object.matrixWorldNeedsUpdate = true;
    }
  }

  // About a name at a place of the window: left, top, right, bottom.
  boxOf({ lift_px }: NameText, [width, height]: readonly [number, number], [x, y]: readonly number[]): [number, number, number, number] {
    const bottom = y! - lift_px - kGap_px;
    return [x! - width / 2 - 2, bottom - height - 1, x! + width / 2 + 2, bottom + 1];
  }

  private async fetchLibrary(): Promise<void> {
    this.library = 'coming';
    this.library = await (fetched ??= fetchTroika());
  }

  private make(library: Troika, name: NameText): Made {
    const object = new library.Text();
    Object.assign(object, {
      text: name.text, fontSize: 1, anchorX: 'center', anchorY: 'bottom', color: 0xffffff, outlineWidth: 0.1, outlineColor: 0x0b1016, outlineOpacity: 0.8, outlineBlur: 0.12, sdfGlyphSize: 64,
      depthOffset: 0, visible: false, frustumCulled: false, matrixAutoUpdate: false, renderOrder: 20,
    });
    for (const material of [object.material].flat()) Object.assign(material, { depthTest: false, depthWrite: false, fog: false, toneMapped: false });
    const made: Made = { ...name, object, size: null };
    this.made.set(name.id, made);
    this.object.add(object);
    object.sync(() => {
      const [left, bottom, right, top] = object.textRenderInfo!.blockBounds as [number, number, number, number];
      made.size = [kFont_px * (right - left), kFont_px * (top - bottom)];
    });
    return made;
  }
  private drop(id: number): void {
    const { object } = this.made.get(id)!;
    this.object.remove(object);
    object.dispose();
    this.made.delete(id);
  }
}

async function fetchTroika(): Promise<Troika> {
  const [library, { default: font }] = await Promise.all([import('troika-three-text'), import('dejavu-fonts-ttf/ttf/DejaVuSans-Bold.ttf?url')]);
  // In this thread: the page's policy lets no worker be made of text.
  library.configureTextBuilder({ useWorker: false, defaultFontURL: new URL(font, window.location.href).href });
  return library;
}

const kAt = new THREE.Vector3(), kScale = new THREE.Vector3();
