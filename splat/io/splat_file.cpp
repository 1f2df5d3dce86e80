#include "splat/io/splat_file.h"

#include "splat/base/error.h"
#include "splat/io/glb.h"
#include "splat/io/ply.h"
#include "splat/io/splat_primitive.h"
#include "splat/io/vq_file.h"

namespace cosplat {
namespace {

Gaussians ReadQuantised(const std::string& path) {
  const QuantisedSplats splats = ReadVqFile(path);
  if (splats.kind != "scene")
    throw Error(path, "splats.json", "kind is '" + splats.kind + "', expected 'scene'");
  return Dequantise(splats);
}

}  // namespace

Gaussians ReadSplats(const std::string& path) {
  Gaussians g = IsVqFile(path) ? ReadQuantised(path) : ReadPly(path);
  FindDegrees(g);
  return g;
}

void WriteSceneGlb(const std::string& path, const Gaussians& gaussians, bool truncate_degree) {
  Gaussians turned = gaussians;
  TurnToGltfAxes(turned);
  GlbDocument document;
  document.path = path;
  document.meshes.push_back({"splats", {AddSplats(document, turned, truncate_degree)}, {}});
  document.scenes.push_back({"scene", {0}});
  document.extensions_used = {kSplatExtension};
  WriteGlb(document);
}

}  // namespace cosplat
