// Whether the browser can draw: it has WebGL 2, and a graphics card that is not being reset.
export function canDraw(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const is_able = gl !== null && !gl.isContextLost();
  gl?.getExtension('WEBGL_lose_context')?.loseContext(); // a browser keeps few contexts
  return is_able;
}
