// Gives a camera to a globe or to a map: its pointers see what the picture draws, its heights and normals are the client core's.
import type { Terrain } from '@foreland/client';
import { readSea, type Sea } from '@foreland/client/three';
import * as THREE from 'three';
import type { Picture } from '../draw/picture';
import type { Controls } from '../ui/controls';
import type { PlaceView } from '../globe/place_text';
import { GlobeHands } from '../ui/globe_hands';
import { MapHands } from '../ui/map_hands';
import type { Body } from '../ui/globe_moves';

export function bodyOf(terrain: Pick<Terrain, 'toGeodetic'>): Body {
  return {
    up: (point) => new THREE.Vector3().fromArray(terrain.toGeodetic(point.toArray()).up),
    height: (point) => terrain.toGeodetic(point.toArray()).height,
  };
}

// The air comes when it comes; without it the globe is drawn in space.
export async function takeAir(terrain: Terrain, picture: Picture): Promise<void> {
  const { Air, kGlobeFragment, kSeaFragment, kSpaceFragment } = await import('../draw/air');
  picture.takeAir({ air: await Air.load(terrain.scene.ellipsoid!), ground: kGlobeFragment, sea: kSeaFragment, sky: kSpaceFragment });
}

// What the server tells of the sea; null where it does not: servers of before the sea, and others' files of a page.
export async function askSea(terrain: Terrain): Promise<Sea | null> {
  const answer = await fetch(new URL('sea.bin', terrain.files));
  return answer.ok ? readSea(await answer.arrayBuffer()) : null;
}

const kAbove_m = 20e3; // where no height is told, straight down

// x, y, z in metres, heading and pitch in degrees, as `view=` has them; null on maps.
export function viewAt(terrain: Terrain, at: PlaceView | null): number[] | null {
  if (!at || terrain.scene.frame === 'planar') return null;
  const { lat, lon, height = kAbove_m, heading = 0, pitch = -90 } = at;
  return [...terrain.toScene({ lat, lon, height }), heading, pitch];
}

const sizeOfWindow = () => ({ width: window.innerWidth, height: window.innerHeight });

export function takeMap(controls: Controls, terrain: Terrain, picture: () => Picture): void {
  const ground = (x: number, y: number) => {
    const met = picture().heldAt(x, y);
    return met && new THREE.Vector3().fromArray(met.point);
  };
  controls.takeMap(new MapHands(controls, bodyOf(terrain), { ground, size: sizeOfWindow }));
}

export function takeGlobe(controls: Controls, terrain: Terrain, picture: () => Picture): void {
  const body = bodyOf(terrain);
  const seen = { pointer: (x: number, y: number) => picture().pointerAt(x, y), ground: (x: number, y: number) => picture().drawnAt(x, y), size: sizeOfWindow };
  controls.takeGlobe(new GlobeHands(controls, body, seen, terrain.scene.ellipsoid!.semiMajor), body);
}
