// A line that is measured, on the exact ground and over everything, so that no level of detail hides a part of it; its corners, and a place
// on it that is pointed at.
import type { Vector } from '@foreland/client';
import * as THREE from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';

const kColour = '#ffd23d', kPointed = '#ffffff';
const kWidth_px = 3, kCorner_px = 9, kPointed_px = 13;

export class MeasureLine {
  readonly object = new THREE.Group();
  private readonly line = new Line2(new LineGeometry(), new LineMaterial({ color: kColour, linewidth: kWidth_px, depthTest: false, transparent: true }));
  private readonly corners = pointsOf(kColour, kCorner_px);
  private readonly pointed = pointsOf(kPointed, kPointed_px);

  constructor() {
    for (const part of [this.line, this.corners, this.pointed]) {
      part.frustumCulled = false;
      part.visible = false;
      this.object.add(part);
    }
    this.line.renderOrder = 10;
    this.corners.renderOrder = 11;
    this.pointed.renderOrder = 12;
  }

  // From the first corner on, so that floats are exact enough far from the scene's origin.
  show(line: readonly Vector[], corners: readonly Vector[]): void {
    this.pointed.visible = false;
    this.line.visible = line.length > 1;
    this.corners.visible = corners.length > 0;
    if (corners.length === 0) return;
    this.object.position.fromArray(corners[0]!);
    setPoints(this.corners, corners.map((corner) => this.fromFirst(corner)));
    if (line.length < 2) return;
    this.line.geometry.dispose();
    this.line.geometry = new LineGeometry();
    this.line.geometry.setPositions(line.flatMap((point) => this.fromFirst(point)));
  }
  // Nothing: at no place.
  point(place: Vector | null): void {
    this.pointed.visible = place !== null;
    if (place) setPoints(this.pointed, [this.fromFirst(place)]);
  }

  private fromFirst(point: Vector): Vector {
    const { x, y, z } = this.object.position;
    return [point[0] - x, point[1] - y, point[2] - z];
  }
}

function setPoints(points: THREE.Points, positions: readonly Vector[]): void {
  points.geometry.dispose();
  points.geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(positions.flat(), 3));
}

function pointsOf(color: string, size: number): THREE.Points {
  return new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ color, size, sizeAttenuation: false, depthTest: false, transparent: true, map: disc() }));
}

function disc(): THREE.Texture {
  const canvas = Object.assign(document.createElement('canvas'), { width: 32, height: 32 });
  const context = canvas.getContext('2d')!;
  context.fillStyle = '#fff';
  context.arc(16, 16, 15, 0, 2 * Math.PI);
  context.fill();
  return new THREE.CanvasTexture(canvas);
}
