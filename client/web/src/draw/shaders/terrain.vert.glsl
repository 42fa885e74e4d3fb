uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 u_origin;  // of the mesh, from the eye
out vec3 v_from_eye;
void main() {
  vec4 p = blended();
  v_from_eye = p.xyz + u_origin;
  passGround(p);
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(p.xyz, 1.0));
}
