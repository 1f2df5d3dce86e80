// The layouts of splat/io/splat_file.h that the browser's player does not read: their decoders
// (zlib's streams, Zstandard, WebP) are libraries of the machine.
#include "splat/base/error.h"
#include "splat/io/sog.h"
#include "splat/io/spz.h"

namespace cosplat {
namespace {

[[noreturn]] void Refuse(const std::string& path, const std::string& layout) {
  throw Error(path,
              "is a file of " + layout +
                  ", which the browser's player does not read: `cosplat export --splats` makes a "
                  "PLY of it");
}

bool Ends(const std::string& path, const std::string& end) {
  return path.size() >= end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

bool IsSpz(const std::string& path) { return Ends(path, ".spz"); }

Gaussians ReadSpz(const std::string& path) { Refuse(path, "SPZ"); }

bool IsSog(const std::string& path) { return Ends(path, ".sog"); }

Gaussians ReadSog(const std::string& path) { Refuse(path, "SOG"); }

}  // namespace cosplat
