#include "splat/base/files.h"
#include "splat/media/image_io.h"

namespace cosplat {

void WriteImage(const std::string& path, const Image8& image) {
  const std::vector<uint8_t> bytes = EncodeImage(path, image);
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  });
}

void WriteImage(const std::string& path, const Image& image) { WriteImage(path, ToBytes(image)); }

}  // namespace cosplat
