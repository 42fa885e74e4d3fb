in vec3 v_colour;
flat in float v_tile;
uniform sampler2D u_pins;  // tiles of 8 by 8: red is the pin, green what is on it
out vec4 o_colour;
void main() {
  vec2 tile = vec2(mod(v_tile, 8.0), floor(v_tile / 8.0));
  vec4 pin = texture(u_pins, (tile + gl_PointCoord) / 8.0);
  if (pin.a < 0.02) discard;
  vec3 ink = pin.rgb / max(pin.a, 0.02);
  o_colour = vec4(v_colour * max(ink.r - ink.g, 0.0) + ink.g, pin.a);
}
