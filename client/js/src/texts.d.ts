declare module '*.glsl' {
  const text: string;
  export default text;
}
declare module 'foreland:worker' {
  const text: string;
  export default text;
}
declare module 'foreland:wasm' {
  const bytes: Uint8Array<ArrayBuffer>;
  export default bytes;
}
