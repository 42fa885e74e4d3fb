// The sea of a globe: where it lies as seen from the eye, for the shaders (shaders/sea.glsl), and drawn where there is no ground before it. It has
// no mesh: each pixel meets the surface itself, so it is as exact as the pixel, from any height, and nothing competes with the ground's depths.
import type { Ellipsoid } from '@foreland/client';
import { undulationAt, type Sea } from '@foreland/client/three';
import * as THREE from 'three';
import { kSkyVertex, shader } from './shaders';

const kCoarse_m = 1000; // by which coarse ground may lie below all true ground

// Where the eye is.
export interface SeaPlace {
  lat: number;
  lon: number;
  height: number;
}

export class SeaSurface {
  readonly object: THREE.Mesh;
  readonly uniforms = {
    u_sea: { value: 0 }, u_sea_eye: { value: new THREE.Vector3() }, u_sea_radius: { value: 1 }, u_sea_power: { value: 0 }, u_sea_round: { value: 1 }, u_sea_tolerance: { value: 1e-3 },
    u_sea_ahead: { value: new THREE.Vector3() }, u_sea_reversed: { value: false }, u_sea_floor_m: { value: 0 },
  };
  wanted = true;
  private readonly directions = { value: new THREE.Matrix4() };
  private readonly material = shader(kSkyVertex, '', {});
  private sea: Sea | null = null;
  private body: Ellipsoid = { semiMajor: 1, flattening: 0 };
  private lowest_m = 0; // of the ground

  // `sun`: towards it; `up`: at the eye.
  constructor(private readonly sun: THREE.Vector3, private readonly up: THREE.Vector3) {
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    Object.assign(this.material, { depthFunc: THREE.AlwaysDepth });
    this.object = new THREE.Mesh(geometry, this.material);
    Object.assign(this.object, { frustumCulled: false, renderOrder: -0.5, visible: false });
  }

  take(sea: Sea, body: Ellipsoid, lowest_m: number): void {
    Object.assign(this, { sea, body, lowest_m });
  }
  // Through the air; until it is there, no sea is drawn.
  takeAir(fragment: string, uniforms: Record<string, THREE.IUniform>): void {
    this.material.fragmentShader = fragment;
    Object.assign(this.material.uniforms, uniforms, this.uniforms, { u_directions: this.directions, u_sun: { value: this.sun }, u_up: { value: this.up } });
    this.material.needsUpdate = true;
  }
  dispose(): void {
    this.object.geometry.dispose();
    this.material.dispose();
  }

  // Whether there is one, drawn or not.
  get exists(): boolean {
    return this.sea?.isDrawn ?? false;
  }
  // Of the sea that is wanted, above the ellipsoid; null where there is none.
  heightAt({ lat, lon }: { lat: number; lon: number }): number | null {
    if (!this.exists || !this.wanted) return null;
    return this.sea!.undulations ? undulationAt(this.sea!.undulations, lat, lon) : 0;
  }

  // For a frame. Who dives below it sees the floor.
  place(camera: THREE.PerspectiveCamera, at: SeaPlace | null, tolerance_rad: number, is_reversed: boolean): void {
    const u = this.uniforms, sea_m = at && this.heightAt(at), is_drawn = at !== null && sea_m !== null && at.height > sea_m && this.material.fragmentShader !== '';
    this.object.visible = is_drawn;
    u.u_sea.value = is_drawn ? 1 : 0;
    if (!is_drawn) return;
    const { semiMajor, flattening } = this.body, radius = semiMajor + sea_m, round = radius / (semiMajor * (1 - flattening) + sea_m);
    const eye = u.u_sea_eye.value.copy(camera.position).multiply(kAxes.set(1, 1, round));
    const { x, y, z } = eye, distance = Math.sqrt(x * x + y * y + z * z); // a Vector3 holds doubles
    u.u_sea_power.value = (distance - radius) * (distance + radius);
    u.u_sea_radius.value = radius;
    u.u_sea_round.value = round;
    u.u_sea_tolerance.value = tolerance_rad;
    u.u_sea_floor_m.value = sea_m - this.lowest_m + kCoarse_m;
    u.u_sea_reversed.value = is_reversed;
    camera.getWorldDirection(u.u_sea_ahead.value);
    this.directions.value.makeRotationFromQuaternion(camera.quaternion).multiply(camera.projectionMatrixInverse);
  }

  // From the eye of the last frame along a unit direction; null where it is not met.
  distanceAlong(direction: THREE.Vector3): number | null {
    const u = this.uniforms;
    if (u.u_sea.value === 0) return null;
    const ray = kRay.copy(direction).multiply(kAxes.set(1, 1, u.u_sea_round.value)), a = ray.lengthSq(), b = ray.dot(u.u_sea_eye.value), c = u.u_sea_power.value, d = b * b - a * c;
    return b >= 0 || d < 0 ? null : c / (Math.sqrt(d) - b);
  }
}

const kAxes = new THREE.Vector3(), kRay = new THREE.Vector3();
