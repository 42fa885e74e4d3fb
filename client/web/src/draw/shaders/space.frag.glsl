in vec3 v_direction;
out vec4 o_colour;
void main() {
  o_colour = vec4(toScreen(skyInAir(normalize(v_direction))), 1.0);
}
