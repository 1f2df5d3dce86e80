#include "splat/io/splat_file.h"

#include "splat/base/error.h"
#include "splat/io/ply.h"
#include "splat/io/vq_file.h"

namespace cosplat {

Gaussians ReadSplats(const std::string& path) {
  if (!IsVqFile(path)) return ReadPly(path);
  const QuantisedSplats splats = ReadVqFile(path);
  if (splats.kind != "scene")
    throw Error(path, "splats.json", "kind is '" + splats.kind + "', expected 'scene'");
  return Dequantise(splats);
}

}  // namespace cosplat
