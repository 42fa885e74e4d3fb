// Notes what a worker of the client does for a mesh: when the keyframe's message was given to the module, when that had decoded it and
// made the mesh, and when what has changed was posted. To be loaded before the worker itself. Milliseconds since 1970.
const { instantiate } = WebAssembly, post = self.postMessage;
const now = () => performance.timeOrigin + performance.now();
const times = { given: 0, made: 0 };

WebAssembly.instantiate = async (module, imports) => {
  const { exports } = await instantiate(module, imports);
  const foreland_receive = (...args) => {
    const given = now(), result = exports.foreland_receive(...args);
    Object.assign(times, { given, made: now() });
    return result;
  };
  return { exports: { ...exports, foreland_receive } };
};
self.postMessage = (message, memory) => {
  if (message.kind === 'mesh') message.update.times = { ...times, posted: now() };
  post.call(self, message, memory);
};
