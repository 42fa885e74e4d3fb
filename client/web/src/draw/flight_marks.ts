// A flight that is followed: its line in the air, brighter where it has been, and the aircraft, as large on the screen wherever it is.
import type { Vector } from '@foreland/client';
import * as THREE from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';

const kWhole = '#cfe2f5', kFlown = '#ffb03d', kAircraft = '#ffb03d', kBelly = '#c9761c';
const kSize = 0.045; // of the aircraft, of its distance
const kEye = new THREE.Vector3();

export class FlightMarks {
  readonly lines = new THREE.Group();
  readonly aircraft = new THREE.Group();
  private readonly whole = lineOf(kWhole, 1.6, 0.55);
  private readonly flown = lineOf(kFlown, 3, 0.95);

  constructor() {
    this.lines.add(this.whole, this.flown);
    this.lines.visible = this.aircraft.visible = false;
    this.aircraft.add(hull());
  }

  // Nothing where there are no points. Relative to the first point, so that floats are exact enough far from the scene's origin.
  show(points: readonly Vector[]): void {
    this.lines.visible = points.length > 1;
    this.aircraft.visible = false;
    if (points.length < 2) return;
    this.lines.position.fromArray(points[0]!);
    const positions = points.flatMap((point) => point.map((v, k) => v - points[0]![k]!));
    for (const line of [this.whole, this.flown]) {
      line.geometry.dispose();
      line.geometry = new LineGeometry();
      line.geometry.setPositions(positions);
    }
    this.flown.geometry.instanceCount = 0;
  }

  // `share` of the line's points are behind it.
  place(at: Vector, ahead: Vector, up: Vector, segments: number, has_aircraft: boolean): void {
    this.flown.geometry.instanceCount = segments;
    this.aircraft.visible = has_aircraft;
    this.aircraft.position.fromArray(at);
    this.aircraft.up.fromArray(up);
    this.aircraft.lookAt(at[0] + ahead[0], at[1] + ahead[1], at[2] + ahead[2]);
  }

  // Draws a scene that they are in. An aircraft that is nearer than the ground can be is drawn over it, with depths of its own.
  draw(renderer: THREE.WebGLRenderer, scene: THREE.Scene, camera: THREE.PerspectiveCamera): void {
    const { aircraft } = this, distance = aircraft.position.distanceTo(kEye.setFromMatrixPosition(camera.matrixWorld)), is_near = aircraft.visible && distance < 1.2 * camera.near;
    aircraft.scale.setScalar(kSize * distance);
    aircraft.visible &&= !is_near;
    renderer.clear();
    renderer.render(scene, camera);
    if (!is_near) return;
    aircraft.visible = true;
    renderer.clearDepth();
    Object.assign(camera, { near: 0.5 * distance, far: 2 * distance });
    camera.updateProjectionMatrix();
    renderer.render(aircraft, camera);
  }
}

function lineOf(color: string, linewidth: number, opacity: number): Line2 {
  const line = new Line2(new LineGeometry(), new LineMaterial({ color, linewidth, transparent: true, opacity, depthWrite: false }));
  line.frustumCulled = false;
  return line;
}

// An arrow's head with a keel, that points along +z.
function hull(): THREE.Mesh {
  const nose = [0, 0, 1], left = [0.62, 0.05, -0.62], right = [-0.62, 0.05, -0.62], tail = [0, 0.12, -0.3], keel = [0, -0.2, -0.42];
  const faces = [nose, left, tail, nose, tail, right, nose, keel, left, nose, right, keel, left, keel, tail, tail, keel, right];
  const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(faces.flat(), 3));
  geometry.computeVertexNormals();
  const top = new THREE.Color(kAircraft), below = new THREE.Color(kBelly);
  const colours = faces.flatMap((_, i) => (Math.floor(i / 3) === 0 ? top : Math.floor(i / 3) === 1 ? top.clone().lerp(below, 0.35) : below).toArray());
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(colours, 3));
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide }));
}
