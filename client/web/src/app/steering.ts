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

  // `sea`: its height at a place, where there is one.
  constructor(readonly controls: Controls, private readonly guides: () => readonly Guide[], private readonly sea: (place: { lat: number; lon: number }) => number | null) {}

  // To where the page's address says (x, y, z in metres, heading and pitch in degrees), or to the first view of the scene.
  enter(scene: Scene, view: readonly number[] | null): void {
    const { controls } = this;
    controls.setScene(scene);
    const { eye, look } = startView(scene);
    const [heading, pitch] = (view?.slice(3) ?? []).map((degrees) => (degrees * Math.PI) / 180);
    controls.jumpTo(view?.slice(0, 3) ?? eye, heading === undefined ? look : { heading, pitch: pitch! });
  }

  // `up` becomes that of the new eye. A camera whose view is frozen is steered.
  step(terrain: Terrain, now_ms: number, seconds: number, up: THREE.Vector3, is_frozen: boolean): Place | null {
    const { controls } = this;
    controls.readPad(seconds);
    const guided = this.guides().map((guide) => guide.pose(terrain, now_ms)).find((pose) => pose !== null);
    if (guided && !is_frozen) {
      if (controls.isOnGlobe) up.fromArray(terrain.place(guided.eye)?.up ?? up.toArray());
      controls.jumpTo(guided.eye, lookOf(guided.orientation, up, controls.pole));
    } else {
      controls.step(seconds, up, (from, to) => (controls.isOnGlobe ? this.sweepOverGlobe(terrain, from, to) : sweep(terrain, from, to, controls.clearance_m)));
    }
    const position = terrain.place(controls.eye.toArray());
    if (position) up.fromArray(position.up);
    const surface_m = position && this.surfaceAt(position);
    this.above_ground_m = position && surface_m !== null ? position.height - surface_m : null;
    const distance_m = this.above_ground_m ?? (controls.isOnGlobe ? position?.height ?? null : null);
    if (distance_m !== null) controls.ground_distance_m = Math.max(distance_m, controls.clearance_m);
    return position;
  }

  // Height of ground or sea; of a camera that is in the sea, of the ground. Null where neither is known.
  private surfaceAt(place: Place): number | null {
    const sea_m = 'lat' in place ? this.sea(place) : null, { ground } = place;
    if (sea_m === null || place.height < sea_m) return ground;
    return Math.max(sea_m, ground ?? sea_m);
  }
  // Ways within a face of the globe's lattice keep clear of the ground all along; others, and those of jumps, where they end. Those that begin
  // above the sea end above it.
  private sweepOverGlobe(terrain: Terrain, from: number[], to: number[]): Triple {
    const { clearance_m } = this.controls, ends = [from, to].map((point) => terrain.place(point)), [before, there] = ends, { highest } = terrain.scene.heights;
    if (!before || !there || Math.min(before.height, there.height) > highest + clearance_m) return to as Triple;
    const [face, last] = ends.map((place) => Math.floor((6 * place!.lattice[0]) / terrain.scene.samples[0]));
    const length_m = Math.hypot(...to.map((v, i) => v - from[i]!));
    const eye = face === last && length_m < kLongest_m ? terrain.sweep(from, to, clearance_m) : (to as Triple);
    const place = terrain.place(eye)!, { height, up } = place, sea_m = 'lat' in before && 'lat' in place && before.height > (this.sea(before) ?? Infinity) ? this.sea(place) : null;
    const surface_m = place.ground === null ? sea_m : Math.max(place.ground, sea_m ?? place.ground), missing_m = surface_m === null || length_m === 0 ? 0 : Math.max(surface_m + clearance_m - height, 0);
    return eye.map((v, i) => v + missing_m * up[i]!) as Triple;
  }
}

type Triple = [number, number, number];

function sweep(terrain: Terrain, from: number[], to: number[], clearance_m: number): Triple {
  return terrain.sweep(from, to, clearance_m);
}

const kLongest_m = 20e3; // of a way that is looked at
