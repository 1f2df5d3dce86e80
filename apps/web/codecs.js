// Decoders that the module asks the page for (splat/media/codecs_web.cpp): WebP, which SOG has, by libwebp
// as @jsquash/webp compiles it, and Zstandard, which version 4 of SPZ has, by fzstd. bundle.mjs makes
// dist/codecs.mjs of them, which is loaded with the first file that needs one.
import webp from "@jsquash/webp/codec/dec/webp_dec.js";
import { decompress } from "fzstd";

// What is damaged gives null.
export async function loadCodecs() {
  const decoder = await webp({ locateFile: (file) => new URL(file, import.meta.url).href });
  const orNull = (decode) => (...parameters) => {
    try {
      return decode(...parameters);
    } catch {
      return null;
    }
  };
  return {
    webp: orNull((bytes) => decoder.decode(bytes)?.data),
    unzstd: orNull((bytes, size) => decompress(bytes, new Uint8Array(size))),
  };
}
