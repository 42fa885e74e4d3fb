// Uploads go past the renderer, straight to the graphics interface, and leave its state as they found it: the renderer keeps what it
// believes of that state, and so does whoever else draws in the context. Asking for these values does not reach the graphics card; the
// browser keeps them itself.
const kStores = ['UNPACK_ALIGNMENT', 'UNPACK_ROW_LENGTH', 'UNPACK_SKIP_ROWS', 'UNPACK_SKIP_PIXELS', 'UNPACK_IMAGE_HEIGHT', 'UNPACK_SKIP_IMAGES',
  'UNPACK_FLIP_Y_WEBGL', 'UNPACK_PREMULTIPLY_ALPHA_WEBGL', 'UNPACK_COLORSPACE_CONVERSION_WEBGL'] as const;

// Runs `work` with no vertex array and no buffer of pixels bound, and with rows that follow one another as they are; then binds and sets
// again what was.
export function withOwnState<T>(gl: WebGL2RenderingContext, work: () => T): T {
  const vertices = gl.getParameter(gl.VERTEX_ARRAY_BINDING);
  const buffers = ([['ARRAY_BUFFER', 'ARRAY_BUFFER_BINDING'], ['COPY_READ_BUFFER', 'COPY_READ_BUFFER_BINDING'], ['COPY_WRITE_BUFFER', 'COPY_WRITE_BUFFER_BINDING'],
    ['PIXEL_UNPACK_BUFFER', 'PIXEL_UNPACK_BUFFER_BINDING']] as const).map(([target, binding]) => [gl[target], gl.getParameter(gl[binding])] as const);
  const [flat, array] = [gl.getParameter(gl.TEXTURE_BINDING_2D), gl.getParameter(gl.TEXTURE_BINDING_2D_ARRAY)];
  const [read, draw] = [gl.getParameter(gl.READ_FRAMEBUFFER_BINDING), gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING)];
  const stores = kStores.map((name) => [gl[name], gl.getParameter(gl[name])] as const);
  const has_scissor = gl.isEnabled(gl.SCISSOR_TEST);
  try {
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
    for (const name of kStores) gl.pixelStorei(gl[name], name === 'UNPACK_ALIGNMENT' ? 4 : 0);
    if (has_scissor) gl.disable(gl.SCISSOR_TEST);
    return work();
  } finally {
    gl.bindVertexArray(vertices);
    for (const [target, buffer] of buffers) gl.bindBuffer(target, buffer);
    gl.bindTexture(gl.TEXTURE_2D, flat);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, array);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, read);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, draw);
    for (const [name, value] of stores) gl.pixelStorei(name, value);
    if (has_scissor) gl.enable(gl.SCISSOR_TEST);
  }
}
