#include "splat/io/scene_glb.h"

#include "splat/io/axes.h"
#include "splat/io/glb.h"
#include "splat/io/splat_primitive.h"

namespace cosplat {

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
