uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 u_origin;  // of the mesh, from the eye
in vec2 texture_coordinate;  // in the model's image
out vec3 v_from_eye;
out vec3 v_normal;
out vec2 v_texture_coordinate;
void main() {
  vec4 p = blended();
  v_from_eye = p.xyz + u_origin;
  v_normal = mix(from_normal, to_normal, u_weight);
  v_texture_coordinate = texture_coordinate;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(p.xyz, 1.0));
}
