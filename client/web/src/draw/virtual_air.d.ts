// The bytes that vite.config.js makes of the textures of @takram/three-atmosphere.
declare module 'virtual:air' {
  const url: string;
  export default url;
  export const kAirSizes: { nu: number; mu_s: number; mu: number; r: number };
}
