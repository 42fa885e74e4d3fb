uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 u_origin;  // of the mesh, from the eye
uniform vec3 u_up;
out float v_distance;
out vec2 v_aside;
void main() {
  vec4 p = blended();
  vec4 view = modelViewMatrix * vec4(p.xyz, 1.0);
  v_distance = length(p.xyz + u_origin);
  v_aside = p.xy + u_origin.xy;
  gl_Position = projectionMatrix * vec4(view.xyz * 0.9995, 1.0);  // a hair nearer than the surface
}
