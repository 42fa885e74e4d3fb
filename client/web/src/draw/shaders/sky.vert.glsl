in vec3 position;
uniform mat4 u_directions;  // from the far plane's corners to directions in the scene
out vec3 v_direction;
void main() {
  vec4 far = u_directions * vec4(position.xy, 1.0, 1.0);
  v_direction = far.xyz / far.w;
  gl_Position = vec4(position.xy, 1.0, 1.0);
}
