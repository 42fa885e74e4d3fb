// CesiumJS, as it ships, without imagery, sky and fog: fog would hide ground that is judged.
import * as Cesium from 'cesium';
import { axesOf } from '../earth.mjs';

export async function open({ earth, lens, size, quality, tiles }) {
  const place = Object.assign(document.createElement('div'), { style: `width:${size.width}px;height:${size.height}px` });
  document.body.append(place);
  const widget = new Cesium.CesiumWidget(place, { baseLayer: false, skyBox: false, skyAtmosphere: false, useDefaultRenderLoop: false, scene3DOnly: true, shouldAnimate: false, creditContainer: document.createElement('div') });
  const { scene, camera } = widget;
  scene.fog.enabled = false;
  scene.globe.maximumScreenSpaceError = (quality * size.height) / lens.height_px; // the canvas is so much smaller than the lens
  camera.frustum.fov = 2 * Math.atan((Math.tan(0.5 * lens.fov_rad) * size.width) / size.height); // of the longer side
  let waiting = null;
  scene.globe.tileLoadProgressEvent.addEventListener((count) => void (waiting = count));
  const vector = (v) => new Cesium.Cartesian3(...v);
  const meshes = new WeakMap();
  return {
    // The tiles are asked for from here on.
    async begin() { scene.terrainProvider = await Cesium.CesiumTerrainProvider.fromUrl(`${tiles}quantized`); },
    show({ eye, orientation }) {
      const { up, forward } = axesOf(orientation);
      camera.setView({ destination: vector(earth.sceneToEcef(eye)), orientation: { direction: vector(earth.turnToEcef(forward)), up: vector(earth.turnToEcef(up)) } });
      widget.render();
    },
    isComplete: () => waiting === 0 && scene.globe.tilesLoaded,
    snapshot: () => scene.globe._surface._tilesToRender.map((tile) => tile.data.renderedMesh).filter(Boolean),
    meshesOf: (snapshot, index) => snapshot.map((mesh) => meshes.get(mesh) ?? (meshes.set(mesh, index(triangles(mesh))), meshes.get(mesh))),
  };

  function triangles(mesh) {
    const count = mesh.vertexCountWithoutSkirts ?? mesh.vertices.length / mesh.encoding.stride, position = new Cesium.Cartesian3();
    const [places, points] = [new Float64Array(2 * count), new Float64Array(3 * count)];
    for (let v = 0; v < count; ++v) {
      mesh.encoding.decodePosition(mesh.vertices, v, position);
      const ecef = [position.x, position.y, position.z];
      places.set(earth.toGeodetic(ecef).slice(0, 2), 2 * v);
      points.set(earth.ecefToScene(ecef), 3 * v);
    }
    return { places, scene: points, indices: mesh.indices.subarray(0, mesh.indexCountWithoutSkirts ?? mesh.indices.length) };
  }
}
