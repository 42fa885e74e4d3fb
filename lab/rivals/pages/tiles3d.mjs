// 3DTilesRendererJS with its plugin for quantized-mesh, in a three scene.
import * as THREE from 'three';
import { TilesRenderer } from '3d-tiles-renderer';
import { QuantizedMeshPlugin } from '3d-tiles-renderer/plugins';
import { axesOf } from '../earth.mjs';

export async function open({ earth, lens, size, quality, tiles: url }) {
  const renderer = new THREE.WebGLRenderer({ logarithmicDepthBuffer: true });
  renderer.setPixelRatio(1);
  renderer.setSize(size.width, size.height);
  document.body.append(renderer.domElement);
  const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera((lens.fov_rad * 180) / Math.PI, size.width / size.height, 1, 1e7);
  scene.add(new THREE.HemisphereLight());
  const meshes = new WeakMap();
  let tiles = null, is_loading = true;
  return {
    begin() {
      tiles = new TilesRenderer(`${url}quantized/layer.json`);
      tiles.registerPlugin(new QuantizedMeshPlugin());
      tiles.errorTarget = quality;
      tiles.setCamera(camera);
      tiles.setResolution(camera, lens.width_px, lens.height_px);
      tiles.addEventListener('tiles-load-start', () => void (is_loading = true));
      tiles.addEventListener('tiles-load-end', () => void (is_loading = false));
      scene.add(tiles.group);
    },
    show({ eye, orientation }) {
      const { right, up, forward } = axesOf(orientation), [x, y, z] = [right, up, forward.map((v) => -v)].map((v) => new THREE.Vector3(...earth.turnToEcef(v)));
      camera.position.fromArray(earth.sceneToEcef(eye));
      camera.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(x, y, z));
      camera.updateMatrixWorld();
      tiles?.update();
      renderer.render(scene, camera);
    },
    isComplete: () => !is_loading && tiles.loadProgress === 1 && tiles.visibleTiles.size > 0,
    snapshot() {
      const drawn = [];
      for (const tile of tiles.visibleTiles) tile.engineData.scene?.traverse((mesh) => mesh.isMesh && drawn.push({ geometry: mesh.geometry, at: mesh.matrixWorld.elements.slice() }));
      return drawn;
    },
    meshesOf: (snapshot, index) => snapshot.map(({ geometry, at }) => meshes.get(geometry) ?? (meshes.set(geometry, index(triangles(geometry, at))), meshes.get(geometry))),
  };

  // Without skirts, which are groups of their own.
  function triangles(geometry, m) {
    const { array } = geometry.getAttribute('position'), all = geometry.index.array, [ground] = geometry.groups;
    const indices = ground ? all.subarray(ground.start, ground.start + ground.count) : all, count = array.length / 3;
    const [places, points] = [new Float64Array(2 * count), new Float64Array(3 * count)];
    for (let v = 0; v < count; ++v) {
      const ecef = [0, 1, 2].map((i) => m[i] * array[3 * v] + m[4 + i] * array[3 * v + 1] + m[8 + i] * array[3 * v + 2] + m[12 + i]);
      places.set(earth.toGeodetic(ecef).slice(0, 2), 2 * v);
      points.set(earth.ecefToScene(ecef), 3 * v);
    }
    return { places, scene: points, indices };
  }
}
