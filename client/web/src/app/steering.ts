// Where the camera is: on a tour, along a flight, or where a person has steered it, above the ground.
import type { Place, Pose, Scene, Terrain } from '@foreland/client';
import type * as THREE from 'three';
import { lookOf } from '../ui/camera';
import type { Controls } from '../ui/controls';
import { startView } from '../ui/start_view';

// What may have the camera: null, it has not.
export interface Guide {
  pose(terrain: Terrain, now_ms: number): Pose | null;
}

export class Steering {
  above_ground_m: number | null = null; // where it is known

  constructor(readonly controls: Controls, private readonly guides: () => readonly Guide[]) {}

  // To where the page's address says (x, y, z in metres, heading and pitch in degrees), or to the first view of the scene.
  enter(scene: Scene, view: readonly number[] | null): void {
    const { controls } = this;
    controls.setBox(scene.bounds.low, scene.bounds.high);
    const { eye, look } = startView(scene);
    controls.eye.fromArray(view?.slice(0, 3) ?? eye);
    const [heading, pitch] = (view?.slice(3) ?? []).map((degrees) => (degrees * Math.PI) / 180);
    controls.look = heading === undefined ? look : { heading, pitch: pitch! };
  }

  // `up` becomes that of the new eye. A camera whose view is frozen is steered.
  step(terrain: Terrain, now_ms: number, seconds: number, up: THREE.Vector3, is_frozen: boolean): Place | null {
    const { controls } = this;
    controls.readPad(seconds);
    const guided = this.guides().map((guide) => guide.pose(terrain, now_ms)).find((pose) => pose !== null);
    if (guided && !is_frozen) {
      controls.eye.fromArray(guided.eye);
      controls.look = lookOf(guided.orientation, up);
    } else {
      controls.step(seconds, up, (from, to) => terrain.sweep(from, to, controls.clearance_m));
    }
    const position = terrain.place(controls.eye.toArray());
    if (position) up.fromArray(position.up);
    this.above_ground_m = position && position.ground !== null ? position.height - position.ground : null;
    if (this.above_ground_m !== null) controls.ground_distance_m = Math.max(this.above_ground_m, controls.clearance_m);
    return position;
  }
}
