// Poses between those of a plan. Node and pages; pure.
import { Quaternion, Vector3 } from 'three';

// `share` of the way from one pose to the next: the eye along a line, the orientation evenly along the shorter arc.
export function poseBetween(from, to, share) {
  return {
    eye: new Vector3(...from.eye).lerp(new Vector3(...to.eye), share).toArray(),
    orientation: new Quaternion(...from.orientation).slerp(new Quaternion(...to.orientation), share).toArray(),
  };
}
