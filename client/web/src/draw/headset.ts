// The picture in a headset (WebXR): three's camera, which has an eye for each of the device's views, on a stand in the scene. The stand is
// where the page's own camera is, level; the device moves the head about it, in metres of the scene.
import type { Pose } from '@foreland/client';
import * as THREE from 'three';
import { headView, serves, withRoom, type HeadLens } from './head_view';

export class Headset {
  readonly camera = new THREE.PerspectiveCamera(); // which three places
  lens: HeadLens | null = null; // that is asked for: null until the device has told its views
  onLens: () => void = () => {}; // it is another one
  onTurn: () => void = () => {}; // a session has begun, or ended
  private readonly stand = new THREE.Group();

  constructor(private readonly renderer: THREE.WebGLRenderer) {
    this.stand.add(this.camera);
    for (const event of ['sessionstart', 'sessionend'] as const) renderer.xr.addEventListener(event, () => this.onTurn());
  }

  // Shows what is drawn from now on in the session's device, until that ends.
  async begin(session: XRSession): Promise<void> {
    const { xr } = this.renderer;
    this.lens = null;
    xr.enabled = true;
    xr.cameraAutoUpdate = false;
    xr.setReferenceSpaceType('local');
    await xr.setSession(session);
  }
  get session(): XRSession | null {
    return this.renderer.xr.getSession();
  }
  get isOn(): boolean {
    return this.renderer.xr.isPresenting;
  }

  // The pose of the head whose stand is at a pose, in this frame.
  look({ eye, orientation }: Pose): Pose {
    const { camera, renderer: { xr }, stand } = this;
    stand.position.fromArray(eye);
    stand.quaternion.fromArray(orientation);
    stand.updateMatrixWorld(true);
    xr.updateCamera(camera);
    const cameras: readonly THREE.WebXRCamera[] = xr.getCamera().cameras;
    if (cameras.length === 0) return { eye, orientation };
    const { pose, lens } = headView(cameras.map(({ matrixWorld, projectionMatrix, viewport }) => {
      const position = new THREE.Vector3(), turn = new THREE.Quaternion();
      matrixWorld.decompose(position, turn, new THREE.Vector3());
      return { position, turn, projection: projectionMatrix, width_px: viewport!.z, height_px: viewport!.w };
    }));
    if (!this.lens || !serves(this.lens, lens)) {
      this.lens = withRoom(lens);
      this.onLens();
    }
    return pose;
  }

  // For tests.
  status(): Record<string, unknown> {
    return { headset_eyes: this.isOn ? this.renderer.xr.getCamera().cameras.map(({ matrixWorld }) => new THREE.Vector3().setFromMatrixPosition(matrixWorld).toArray()) : [] };
  }
}
