#include "splat/io/splat_file.h"

#include "splat/io/ply.h"
#include "splat/io/vq_file.h"

namespace cosplat {

Gaussians ReadSplats(const std::string& path) {
  return IsVqFile(path) ? Dequantise(ReadVqFile(path)) : ReadPly(path);
}

}  // namespace cosplat
