// Zstandard and WebP in the browser: the page's decoders (apps/web/src/codecs.js), which the module
// calls by `codecs` of its own object, on the thread that opened it. Where the page gave none, as
// in a page of one file, such a file is refused.
#include <emscripten.h>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/media/webp.h"

// Both return the number of bytes written, or -1: damaged, or of another size; or -2: no decoder.
EM_JS(int,
      cosplat_page_unzstd,
      (const char* bytes, size_t count, unsigned char* out, size_t size),
      {
        if (!Module["codecs"]) return -2;
        const heap = new Uint8Array(wasmMemory.buffer);
        const inflated = Module["codecs"].unzstd(heap.slice(bytes, bytes + count), size);
        if (!inflated || inflated.length != size) return -1;
        new Uint8Array(wasmMemory.buffer).set(inflated, out);
        return size;
      })
EM_JS(int, cosplat_page_webp, (const char* bytes, size_t count, unsigned char* out, size_t size), {
  if (!Module["codecs"]) return -2;
  const heap = new Uint8Array(wasmMemory.buffer);
  const pixels = Module["codecs"].webp(heap.slice(bytes, bytes + count));
  if (!pixels || pixels.length != size) return -1;
  new Uint8Array(wasmMemory.buffer).set(pixels, out);
  return size;
})

namespace cosplat {
namespace {

void CheckDecoded(int written, const std::string& path, const std::string& field) {
  if (written == -2) throw Error(path, field, "needs a decoder, which this page does not have");
  if (written < 0) throw Error(path, field, "is truncated or damaged");
}

}  // namespace

std::vector<unsigned char> Unzstd(const std::string& path,
                                  const std::string& field,
                                  const char* bytes,
                                  size_t count,
                                  size_t size) {
  std::vector<unsigned char> out(size);
  CheckDecoded(cosplat_page_unzstd(bytes, count, out.data(), size), path, field);
  return out;
}

// The size is read here, so that nothing is decoded that has too many pixels. Source: WebP Lossless
// Bitstream Specification, section 3: after RIFF's 12 bytes a chunk "VP8L", its length, the
// signature 0x2f, and width and height less 1 in 14 bits each.
Image8 DecodeWebp(const std::string& path,
                  const std::string& field,
                  const std::vector<char>& bytes,
                  size_t max_pixels) {
  constexpr size_t kSignature = 20, kHeader = 25;
  const auto has = [&](size_t at, const std::string& text) {
    return std::equal(text.begin(), text.end(), bytes.begin() + long(at));
  };
  if (bytes.size() < kHeader || !has(0, "RIFF") || !has(8, "WEBP"))
    throw Error(path, field, "is not a WebP image");
  if (!has(12, "VP8L") || bytes[kSignature] != 0x2f)
    throw Error(path, field, "is not a lossless still image");
  uint32_t sides = 0;
  for (size_t k = 0; k < 4; ++k) sides |= uint32_t(uint8_t(bytes[kSignature + 1 + k])) << 8 * k;
  const int width = int(sides & 0x3fff) + 1, height = int(sides >> 14 & 0x3fff) + 1;
  if (size_t(width) * size_t(height) > max_pixels)
    throw Error(path,
                field,
                "has " + SizeText(width, height) + " pixels, at most " +
                    std::to_string(max_pixels) + " are expected");
  Image8 image(width, height, 4);
  CheckDecoded(cosplat_page_webp(bytes.data(), bytes.size(), image.data.data(), image.data.size()),
               path,
               field);
  return image;
}

}  // namespace cosplat
