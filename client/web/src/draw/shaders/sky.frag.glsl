in vec3 v_direction;
out vec4 o_colour;
void main() {
  if (IS_GLOBE) o_colour = vec4(0.0, 0.0, 0.0, 1.0);
  else o_colour = vec4(toScreen(skyColour(normalize(v_direction))), 1.0);
}
