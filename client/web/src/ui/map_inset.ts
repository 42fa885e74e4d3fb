// A small map, north up: the whole scene in relief, by heights of the server, with where the camera is and what it sees. A click goes there.
import type { MapPoint, Scene, Terrain } from '@foreland/client';
import { kLens } from './settings';

const kSide = 160; // samples, and pixels of the page
const kCone = 0.22; // of the map's side
const kEdge = 8; // pixels, which the camera's mark keeps to
const kLight = [-0.55, 0.55, 0.63] as const; // as on maps, from the north-west

export class MapInset {
  private readonly canvas = Object.assign(document.createElement('canvas'), { width: 2 * kSide, height: 2 * kSide, tabIndex: -1 });
  private ground: HTMLCanvasElement | null = null;
  private wanted: Terrain | null = null; // whose ground it is, or is to be
  private is_on = false;

  // `onPlace` is told of a point of the scene to look at, x and y in metres.
  constructor(private readonly root: HTMLElement, private readonly onPlace: (x: number, y: number) => void) {
    this.canvas.setAttribute('role', 'img');
    root.append(this.canvas);
    root.hidden = true;
    this.canvas.onclick = (event) => {
      const { left, top, width, height } = this.canvas.getBoundingClientRect();
      const at = this.wanted?.hasScene && fromMap(this.wanted.scene, (event.clientX - left) / width, (event.clientY - top) / height);
      if (at) this.onPlace(...at);
    };
  }

  // For tests.
  status(): Record<string, unknown> {
    return { map: this.is_on && this.ground !== null };
  }
  setOn(is_on: boolean): void {
    this.is_on = is_on;
    this.root.hidden = !is_on;
    document.body.classList.toggle('with-map', is_on);
  }

  // With each frame.
  update(terrain: Terrain, eye: readonly number[], heading_rad: number, aspect: number): void {
    if (!this.is_on || !terrain.hasScene) return;
    if (this.wanted !== terrain) {
      this.wanted = terrain;
      this.ground = null;
      reliefOf(terrain).then((ground) => (this.ground = ground), () => (this.wanted = null)); // asked for again
    }
    this.draw(terrain.scene, eye, heading_rad, aspect);
  }

  private draw(scene: Scene, eye: readonly number[], heading_rad: number, aspect: number): void {
    const context = this.canvas.getContext('2d')!, side = this.canvas.width;
    context.clearRect(0, 0, side, side);
    if (this.ground) context.drawImage(this.ground, 0, 0, side, side);
    const [u, v] = onMap(scene, eye), [x, y] = [u, v].map((share) => Math.min(Math.max(share * side, kEdge), side - kEdge)) as [number, number];
    const half = Math.atan(Math.tan(kLens.fov_rad / 2) * aspect), north = -Math.PI / 2 + heading_rad, cone = context.createRadialGradient(x, y, 0, x, y, kCone * side);
    cone.addColorStop(0, 'rgba(255, 255, 255, 0.75)');
    cone.addColorStop(1, 'rgba(255, 255, 255, 0)');
    context.fillStyle = cone;
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, kCone * side, north - half, north + half);
    context.fill();
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = '#ff7a66';
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = '#fff';
    context.stroke();
    this.canvas.ariaLabel = `Map of the scene. The camera is ${Math.round(100 * u)} % from the west and ${Math.round(100 * (1 - v))} % from the south.`;
  }
}

// In a square, whose middle is the scene's and whose side its longer one: from the west and from the north, 0 to 1.
function onMap({ bounds: { low, high } }: Scene, [x, y]: readonly number[]): [number, number] {
  const side = Math.max(high[0] - low[0], high[1] - low[1]), [mx, my] = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  return [0.5 + (x! - mx) / side, 0.5 - (y! - my) / side];
}
function fromMap({ bounds: { low, high } }: Scene, u: number, v: number): [number, number] {
  const side = Math.max(high[0] - low[0], high[1] - low[1]);
  return [(low[0] + high[0]) / 2 + (u - 0.5) * side, (low[1] + high[1]) / 2 + (0.5 - v) * side];
}

async function reliefOf(terrain: Terrain): Promise<HTMLCanvasElement> {
  const { scene } = terrain, places: MapPoint[] = [];
  for (let j = 0; j < kSide; ++j)
    for (let i = 0; i < kSide; ++i) places.push(terrain.toGeodetic([...fromMap(scene, (i + 0.5) / kSide, (j + 0.5) / kSide), 0]));
  const heights = await terrain.heights(places), { lowest, highest } = scene.heights, cell_m = Math.max(scene.bounds.high[0] - scene.bounds.low[0], scene.bounds.high[1] - scene.bounds.low[1]) / kSide;
  const picture = new ImageData(kSide, kSide), steep = Math.max(1, (0.12 * cell_m * kSide) / Math.max(highest - lowest, 1e-3)); // flat scenes show their relief, too
  const at = (i: number, j: number) => heights[Math.min(Math.max(j, 0), kSide - 1) * kSide + Math.min(Math.max(i, 0), kSide - 1)]!;
  for (let j = 0; j < kSide; ++j)
    for (let i = 0; i < kSide; ++i) {
      const h = at(i, j), k = 4 * (j * kSide + i);
      if (Number.isNaN(h)) continue;
      const slope = (a: number, b: number) => (Number.isNaN(a) || Number.isNaN(b) ? 0 : (steep * (b - a)) / (2 * cell_m));
      const normal = [-slope(at(i - 1, j), at(i + 1, j)), -slope(at(i, j + 1), at(i, j - 1)), 1], length = Math.hypot(...normal);
      const light = 0.45 + 0.85 * Math.max(normal.reduce((sum, n, axis) => sum + (n / length) * kLight[axis]!, 0), 0), share = (h - lowest) / Math.max(highest - lowest, 1e-3);
      picture.data.set([(70 + 120 * share) * light, (95 + 85 * share) * light, (62 + 115 * share) * light, 255], k);
    }
  const canvas = Object.assign(document.createElement('canvas'), { width: kSide, height: kSide });
  canvas.getContext('2d')!.putImageData(picture, 0, 0);
  return canvas;
}
