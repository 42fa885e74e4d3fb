in vec3 position;
in vec2 height;  // of the place; of the ground above it over that
uniform mat4 modelViewMatrix, projectionMatrix;
uniform vec3 u_wall;  // its origin, from the eye
out vec3 v_from_eye;
out vec2 v_height;
void main() {
  v_from_eye = position + u_wall;
  v_height = height;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0));
}
