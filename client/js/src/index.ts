/** Terrain and objects that a Foreland server streams, for any page or program: without three, and without a document. */
export { ForelandError, type ErrorCode } from './errors.js';
export { type TerrainEvents } from './events.js';
export { type Blend, type Lens, type Limits, type OpenOptions, type Predictor, type Strategy, type TerrainOptions } from './options.js';
export { type BothHeights, type Ellipsoid, type MapPoint, type Place, type Scene, type Vector } from './scene.js';
export { type Sight, type SightOptions, type ViewshedQuestion } from './sight.js';
export { type Viewshed } from './core/sight.js';
export { type MeshSink } from './mesh_sink.js';
export { type Hit } from './object_triangles.js';
export { type Frame } from './frame.js';
export { Terrain, type Pose } from './terrain.js';
export { type ChannelName, type ChannelUpdate, type MeshUpdate, type PartLines, type PartUpdate } from './core/mesh_update.js';
export { type TileUpdate, type TileUpload } from './core/tile_update.js';
export { kBlends, kPredictors, kStrategies, type FrameKind, type Region, type Statistics, type ZeroSurface } from './core/values.js';
