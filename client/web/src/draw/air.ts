// The air about a globe, by the shaders and textures of @takram/three-atmosphere: in the ground's own shading and the sky's. A chunk of its own,
// which only globes load.
import { common as functions, definitions, runtime } from '@takram/three-atmosphere/shaders/bruneton';
import { glsl } from '@foreland/client/three';
import type { Ellipsoid } from '@foreland/client';
import * as THREE from 'three';
import bytes_url, { kAirSizes } from 'virtual:air';
import air from './shaders/air.glsl?raw';
import atmosphere from './shaders/atmosphere.glsl?raw';
import globeFrag from './shaders/globe.frag.glsl?raw';
import head from './shaders/head.glsl?raw';
import light from './shaders/light.glsl?raw';
import overlay from './shaders/overlay.glsl?raw';
import sea from './shaders/sea.glsl?raw';
import seaFrag from './shaders/sea.frag.glsl?raw';
import spaceFrag from './shaders/space.frag.glsl?raw';
import viewshed from './shaders/viewshed.glsl?raw';

const kBottom_km = 6360, kTransmittance = [256, 64] as const, kIrradiance = [64, 16] as const;
const sizes = kAirSizes;
const kSizes = Object.entries({
  TRANSMITTANCE_TEXTURE_WIDTH: kTransmittance[0], TRANSMITTANCE_TEXTURE_HEIGHT: kTransmittance[1], IRRADIANCE_TEXTURE_WIDTH: kIrradiance[0], IRRADIANCE_TEXTURE_HEIGHT: kIrradiance[1],
  SCATTERING_TEXTURE_R_SIZE: sizes.r, SCATTERING_TEXTURE_MU_SIZE: sizes.mu, SCATTERING_TEXTURE_MU_S_SIZE: sizes.mu_s, SCATTERING_TEXTURE_NU_SIZE: sizes.nu,
}).map(([name, value]) => `#define ${name} ${value}`).join('\n');

// The package's AtmosphereParameters, of which the textures are; kilometres.
const kParameters = `
const AtmosphereParameters ATMOSPHERE = AtmosphereParameters(
  vec3(1.474, 1.8504, 1.91198), 0.004675, ${kBottom_km}.0, 6420.0,
  DensityProfile(DensityProfileLayer[2](DensityProfileLayer(0.0, 0.0, 0.0, 0.0, 0.0), DensityProfileLayer(0.0, 1.0, -0.125, 0.0, 0.0))), vec3(0.005802, 0.013558, 0.0331),
  DensityProfile(DensityProfileLayer[2](DensityProfileLayer(0.0, 0.0, 0.0, 0.0, 0.0), DensityProfileLayer(0.0, 1.0, -0.833333, 0.0, 0.0))), vec3(0.003996), vec3(0.00444), 0.8,
  DensityProfile(DensityProfileLayer[2](DensityProfileLayer(25.0, 0.0, 0.0, 1.0 / 15.0, -2.0 / 3.0), DensityProfileLayer(0.0, 0.0, 0.0, -1.0 / 15.0, 8.0 / 3.0))),
  vec3(0.00065, 0.001881, 0.000085), vec3(0.1), -0.5);
const vec3 SUN_SPECTRAL_RADIANCE_TO_LUMINANCE = vec3(1.29751, 0.92389, 0.87795), SKY_SPECTRAL_RADIANCE_TO_LUMINANCE = vec3(1.51849, 0.94174, 0.86257);
uniform highp sampler2D transmittance_texture, irradiance_texture;
uniform highp sampler3D scattering_texture, single_mie_scattering_texture;
`;

const kAir = `precision highp sampler3D;\n#define COMBINED_SCATTERING_TEXTURES\n#define GROUND\n${kSizes}\n${definitions}${kParameters}${functions}${runtime}${air}`;
export const kGlobeFragment = head + glsl.common + atmosphere + light + glsl.tiles + glsl.ground + viewshed + overlay + kAir + sea + globeFrag;
export const kSeaFragment = head + glsl.common + atmosphere + kAir + sea + seaFrag;
export const kSpaceFragment = head + glsl.common + atmosphere + kAir + spaceFrag;

export class Air {
  readonly uniforms: Record<string, THREE.IUniform>;
  private readonly scale: THREE.Vector3;

  private constructor({ semiMajor, flattening }: Ellipsoid, texels: Uint16Array<ArrayBuffer>) {
    const scale = kBottom_km / semiMajor;
    this.scale = new THREE.Vector3(scale, scale, scale / (1 - flattening));
    const [t, i] = [4 * kTransmittance[0] * kTransmittance[1], 4 * kIrradiance[0] * kIrradiance[1]];
    const scattering = filtered(new THREE.Data3DTexture(texels.slice(t + i), sizes.nu * sizes.mu_s, sizes.mu, sizes.r));
    this.uniforms = {
      transmittance_texture: { value: filtered(new THREE.DataTexture(texels.slice(0, t), ...kTransmittance)) }, irradiance_texture: { value: filtered(new THREE.DataTexture(texels.slice(t, t + i), ...kIrradiance)) },
      scattering_texture: { value: scattering }, single_mie_scattering_texture: { value: scattering },
      u_air: { value: 1 }, u_air_eye: { value: new THREE.Vector3() }, u_air_scale: { value: this.scale },
    };
  }

  // About a body of the earth's kind.
  static async load(ellipsoid: Ellipsoid): Promise<Air> {
    const answer = await fetch(new URL(bytes_url, window.location.href));
    if (!answer.ok) throw new Error(`The air's textures do not come: the server answers ${answer.status}.`);
    return new Air(ellipsoid, new Uint16Array(await answer.arrayBuffer()));
  }
  dispose(): void {
    for (const { value } of Object.values(this.uniforms)) if (value instanceof THREE.Texture) value.dispose();
  }

  // Of the camera that is drawn from; never below the ball.
  place(eye: THREE.Vector3): void {
    const at = this.uniforms.u_air_eye!.value.copy(eye).multiply(this.scale) as THREE.Vector3;
    at.setLength(Math.max(at.length(), kBottom_km + 0.002));
  }
}

function filtered<T extends THREE.DataTexture | THREE.Data3DTexture>(texture: T): T {
  return Object.assign(texture, { type: THREE.HalfFloatType, format: THREE.RGBAFormat, minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter, needsUpdate: true });
}
