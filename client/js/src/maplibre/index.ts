/** A terrain as a layer of a MapLibre map. */
export { ForelandLayer, type ForelandLayerOptions } from './foreland_layer.js';
