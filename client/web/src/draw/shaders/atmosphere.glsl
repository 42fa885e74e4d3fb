// Sky, haze and the way to the screen, shared so that distant ground fades into the very sky behind it.
// Of the sky's light: 1 by day.
float daylight() {
  return mix(0.03, 1.0, smoothstep(-0.25, 0.12, dot(u_sun, u_up)));
}

// White by day, red when the sun is low, black when it has set.
vec3 sunColour() {
  float height = dot(u_sun, u_up);
  return mix(vec3(2.30, 1.05, 0.42), vec3(2.15, 1.92, 1.56), smoothstep(0.0, 0.30, height)) * smoothstep(-0.05, 0.03, height);
}

vec3 hazeColour(vec3 direction) {
  float towards_sun = max(dot(direction, u_sun), 0.0);
  float is_low = 1.0 - smoothstep(0.0, 0.30, dot(u_sun, u_up));
  vec3 glow = mix(vec3(0.95, 0.80, 0.60), vec3(1.15, 0.52, 0.24), is_low);
  return daylight() * mix(vec3(0.36, 0.50, 0.68), glow, (0.50 + 0.3 * is_low) * pow(towards_sun, 6.0 - 3.0 * is_low));
}

vec3 skyColour(vec3 direction) {
  float height = dot(direction, u_up);
  vec3 haze = hazeColour(direction);
  vec3 colour = mix(haze, daylight() * vec3(0.030, 0.105, 0.310), 1.0 - exp(-5.5 * max(height, 0.0)));
  colour = mix(colour, haze * 0.72, smoothstep(0.0, -0.4, height));
  float towards_sun = max(dot(direction, u_sun), 0.0);
  colour += daylight() * vec3(1.0, 0.80, 0.55) * (0.10 * pow(towards_sun, 24.0) + 0.35 * pow(towards_sun, 350.0));
  return colour + (vec3(9.0, 8.0, 6.0) / vec3(2.15, 1.92, 1.56)) * sunColour() * smoothstep(0.99985, 0.99993, towards_sun);
}

// Filmic curve (Narkowicz's fit of ACES), then sRGB.
vec3 toScreen(vec3 colour) {
  vec3 x = colour * 0.80;
  x = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), x));
}
