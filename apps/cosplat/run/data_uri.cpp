#include "apps/cosplat/run/data_uri.h"

#include "splat/media/image_io.h"

namespace cosplat {

std::string Base64(const std::vector<uint8_t>& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string ImageUri(const Image8& image, const std::string& extension) {
  const std::string type = extension == ".png" ? "image/png" : "image/jpeg";
  return "data:" + type + ";base64," + Base64(EncodeImage("image" + extension, image));
}

}  // namespace cosplat
