// A terrain as a layer of a map: a ForelandTerrain in a three scene of its own, drawn by the map's camera into the map's picture and depths.
import type { CustomLayerInterface, CustomRenderMethodInput, Map } from 'maplibre-gl';
import * as THREE from 'three';
import { ForelandError } from '../errors.js';
import type { Frame } from '../frame.js';
import type { Terrain } from '../terrain.js';
import { ForelandTerrain, type ForelandTerrainOptions } from '../three/foreland_terrain.js';
import { standardMaterials, type Uniforms } from '../three/materials.js';
import onMap from '../three/shaders/on_map.glsl';
import { Credits } from './credits.js';
import { cameraOfMap, curvesAt, kMapRadius, localOfEarth, type MapCamera } from './map_camera.js';
import { Pulse } from './pulse.js';

const kEarthsDiffer = 0.004; // by so much the map's sphere and the earth's ellipsoid differ, of all lengths
const kMostMoved = 0.25; // radians

export interface ForelandLayerOptions extends Pick<ForelandTerrainOptions, 'style' | 'material' | 'bytesPerFrame' | 'anisotropy'> {
  /** Of the layer in the map's style. */
  id: string;
  /** Whether the credits that are due stand in a corner of the map. Default true; otherwise show those of the terrain's event `attributions`. */
  attribution?: boolean;
}

/**
 * A layer for MapLibre GL JS, 5 or 6: `map.addLayer(new ForelandLayer(terrain, { id: 'terrain' }))`. The scene has to be geographic. Ground
 * lies where the map draws its places, in Mercator's projection and on the globe, and hides and is hidden by the map's other 3D layers. It
 * can be removed and added again; the terrain stays open, and is its owner's to close.
 */
export class ForelandLayer implements CustomLayerInterface {
  readonly id: string;
  readonly type = 'custom';
  readonly renderingMode = '3d';
  /** What is drawn: metres eastward, northward and up from the zero surface below the map's camera. The lights are in it. */
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera();
  /** The ground in that scene; null while the layer is not in a map. */
  ground: ForelandTerrain | null = null;
  /** The last frame that was drawn. */
  frame: Frame | null = null;

  private readonly uniforms: Uniforms = {
    u_map_turn: { value: new THREE.Matrix3() }, u_map_eye: { value: 0 }, u_map_latitude: { value: new THREE.Vector2() },
    u_map_earth: { value: new THREE.Vector3() }, u_map_radius: { value: kMapRadius }, u_map_globe: { value: false },
  };
  private readonly size = { width: 1, height: 1 }; // of the picture that the terrain is asked for
  private readonly credits = new Credits();
  private renderer: THREE.WebGLRenderer | null = null;
  private pulse: Pulse | null = null;
  private offs: (() => void)[] = [];

  constructor(readonly terrain: Terrain, private readonly options: ForelandLayerOptions) {
    this.id = options.id;
    const [sky, sun] = [new THREE.HemisphereLight(0xbfd4ee, 0x7a6f60, 1.2), new THREE.DirectionalLight(0xfff2dd, 2.5)];
    sky.position.set(0, 0, 1);
    sun.position.set(-1, 1, 1);
    this.scene.add(sky, sun);
  }

  /** The map calls it. */
  onAdd(map: Map, gl: WebGLRenderingContext | WebGL2RenderingContext): void {
    const { terrain, options } = this;
    if (!(gl instanceof WebGL2RenderingContext)) throw new ForelandError('unsupported', 'This map draws by WebGL 1.', 'Let it draw by WebGL 2.');
    if (terrain.request.strategy === 'delay') throw new ForelandError('argument', 'A map does not draw late, as the strategy delay asks for.', 'Open the terrain with another strategy.');
    if (terrain.hasScene && !terrain.scene.toEcef) throw notOnEarth(terrain.scene.crs);
    terrain.setOptions({ occlusion: false }); // what a ridge hides on the round earth is seen on a flat map
    this.renderer = rendererOf(map.getCanvas(), gl);
    const materials = standardMaterials({ name: 'onMap', glsl: onMap, uniforms: this.uniforms });
    this.ground = new ForelandTerrain(terrain, { ...options, renderer: this.renderer, materials, size: this.size });
    if (options.material) options.material(this.ground.groundMaterial as THREE.MeshStandardMaterial);
    this.ground.matrixAutoUpdate = false;
    this.scene.add(this.ground);
    this.pulse = new Pulse(() => map.triggerRepaint());
    this.offs = [terrain.on('scene', (scene) => (scene.toEcef ? map.triggerRepaint() : terrain.warn(notOnEarth(scene.crs).message)))];
    if (options.attribution ?? true) {
      map.addControl(this.credits);
      this.offs.push(terrain.on('attributions', (texts) => this.credits.show(texts)), () => map.removeControl(this.credits));
    }
  }
  /** The map calls it. */
  onRemove(): void {
    for (const off of this.offs.splice(0)) off();
    this.pulse?.end();
    this.ground?.dispose();
    [this.pulse, this.ground, this.renderer] = [null, null, null];
  }

  /** The map calls it for each picture. */
  render(gl: WebGLRenderingContext | WebGL2RenderingContext, { defaultProjectionData: data }: CustomRenderMethodInput): void {
    const { ground, renderer, terrain } = this;
    if (!ground || !renderer || !terrain.hasScene || !terrain.scene.toEcef) return;
    // From a globe to Mercator's map the map goes by way of both; here the nearer one is drawn.
    const is_globe = data.projectionTransition > 0.5;
    const has_both = data.projectionTransition > 0;
    this.follow(cameraOfMap(has_both && !is_globe ? data.fallbackMatrix : data.mainMatrix, is_globe), is_globe, gl.drawingBufferWidth, gl.drawingBufferHeight);
    this.frame = ground.update(this.camera, performance.now());
    renderer.setViewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    renderer.resetState();
    renderer.render(this.scene, this.camera);
    this.pulse?.beat(JSON.stringify([ground.drawn, this.frame?.guaranteedPx, terrain.stats.tiles_received, this.camera.matrixWorld.elements]));
  }

  private follow(seen: MapCamera, is_globe: boolean, width: number, height: number): void {
    const { camera, ground, uniforms } = this;
    const ellipsoid = this.terrain.screen!.slopeFrame()!;
    const curves = curvesAt(seen.latitude, ellipsoid);
    ground!.matrix.fromArray(localOfEarth(seen.latitude, seen.longitude, ellipsoid)).multiply(kEarth.fromArray(this.terrain.scene.toEcef!));
    uniforms.u_map_turn!.value.setFromMatrix4(ground!.matrix);
    uniforms.u_map_eye!.value = seen.height;
    uniforms.u_map_latitude!.value.set(Math.sin(seen.latitude), Math.cos(seen.latitude));
    uniforms.u_map_earth!.value.set(curves.axis, curves.meridian, curves.growth);
    uniforms.u_map_globe!.value = is_globe;
    camera.position.set(0, 0, seen.height);
    camera.quaternion.setFromRotationMatrix(kEarth.makeBasis(...(seen.axes.map((axis) => new THREE.Vector3(...axis)) as [THREE.Vector3, THREE.Vector3, THREE.Vector3])));
    camera.projectionMatrix.fromArray(seen.projection);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    this.ask(seen, width, height);
  }

  // Asks for a picture that has the map's in it, though the map moves places, and though the map's axis need not be in its middle; with so
  // much finer pixels that what is guaranteed holds on the map.
  private ask({ edges, latitude }: MapCamera, width: number, height: number): void {
    const reach_m = this.reach();
    const moved = Math.min((reach_m * (1 + Math.abs(Math.tan(latitude)))) / (2 * kMapRadius) + kEarthsDiffer, kMostMoved);
    const widened = (...sides: number[]) => Math.tan(Math.min(Math.atan(Math.max(...sides)) + moved, 1.5));
    const finer = 2 ** (Math.ceil(8 * Math.log2(1 + moved)) / 8);
    const by = (tangent: number, whole: number) => 2 ** (Math.ceil(8 * Math.log2((2 * tangent) / whole)) / 8); // in steps, for a new lens is a new request
    const [whole_x, whole_y] = [edges.left + edges.right, edges.down + edges.up];
    const up = by(widened(edges.down, edges.up), whole_y);
    this.camera.fov = (2 * Math.atan(0.5 * up * whole_y) * 180) / Math.PI;
    this.size.width = Math.round(width * finer * by(widened(edges.left, edges.right), whole_x));
    this.size.height = Math.round(height * finer * up);
  }
  // How far the scene goes, along the ground, from below the eye.
  private reach(): number {
    const { low, high } = this.terrain.scene.bounds;
    let farthest = 0;
    for (const x of [low[0], high[0]])
      for (const y of [low[1], high[1]]) {
        kCorner.set(x, y, 0).applyMatrix4(this.ground!.matrix);
        farthest = Math.max(farthest, Math.hypot(kCorner.x, kCorner.y));
      }
    return farthest;
  }
}

const notOnEarth = (crs: string) => new ForelandError('argument', `The scene is on a map of its own (${crs}), and has no place on the earth.`, 'Build it with --frame geographic.');

// One for each map, for good: three does not give back all that a renderer has made in a context.
const renderers = new WeakMap<WebGL2RenderingContext, THREE.WebGLRenderer>();
function rendererOf(canvas: HTMLCanvasElement, context: WebGL2RenderingContext): THREE.WebGLRenderer {
  const known = renderers.get(context);
  if (known) return known;
  const renderer = new THREE.WebGLRenderer({ canvas, context });
  renderer.autoClear = false;
  renderers.set(context, renderer);
  return renderer;
}

const kEarth = new THREE.Matrix4();
const kCorner = new THREE.Vector3();
