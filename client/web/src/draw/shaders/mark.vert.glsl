// Marks of points: a pin whose tip stands on its place, of the same size wherever it is.
in vec3 position;
in vec3 color;
in vec2 mark;  // its height in pixels of the window; which picture
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float u_ratio;  // pixels of the picture to one of the window
out vec3 v_colour;
flat out float v_tile;
void main() {
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  // A little nearer, so that ground that is coarse far away does not hide it.
  gl_Position = projectionMatrix * vec4(0.99 * at.xyz, 1.0);
  gl_PointSize = 2.0 * mark.x * u_ratio;
  v_colour = color;
  v_tile = mark.y;
}
