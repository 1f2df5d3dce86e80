// The Zstandard module that PlayCanvas' parser of SPZ asks for, by three.js' decoder.
globalThis.ZstdDecoderModule = async () => {
  const { ZSTDDecoder } = await import("/packages/three/examples/jsm/libs/zstddec.module.js");
  const decoder = new ZSTDDecoder();
  await decoder.init();
  return { decompress: (bytes, size) => decoder.decode(bytes, size) };
};
