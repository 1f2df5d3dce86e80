#include "splat/io/splat_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/glb.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_primitive.h"
#include "splat/io/splat_records.h"
#include "splat/io/spz.h"

namespace cosplat {
namespace {

WorldOrigin TurnedToGltfAxes(const WorldOrigin& p) { return {p[0], 0 - p[1], 0 - p[2]}; }

// Turned back to the axes that WriteSceneGlb was given.
Gaussians ReadSceneGlb(const std::string& path) {
  const GlbDocument document = ReadGlb(path, {kSplatExtension});
  const GlbPrimitive& splats = FindSplats(document);
  Gaussians g = ReadSplatPrimitive(document, splats);
  TurnToGltfAxes(g);  // its own inverse
  for (const GlbMesh& mesh : document.meshes)
    for (const GlbPrimitive& primitive : mesh.primitives)
      if (&primitive == &splats) g.origin = TurnedToGltfAxes(mesh.translation);
  return g;
}

Gaussians ReadLayout(const std::string& path) {
  switch (SplatLayoutOf(path)) {
    case SplatLayout::kPly:
      return ReadPly(path);
    case SplatLayout::kSpz:
      return ReadSpz(path);
    case SplatLayout::kSog:
      return ReadSog(path);
    case SplatLayout::kRecords:
      return ReadSplatRecords(path);
    case SplatLayout::kGlb:
      return ReadSceneGlb(path);
    case SplatLayout::kNone:
      break;
  }
  const std::vector<char> bytes = ReadFile(path);  // says so if there is none
  // The name of a ZIP archive's first member follows its header of 30 bytes.
  if (std::string_view(bytes.data(), bytes.size()).substr(0, 41).ends_with("splats.json"))
    throw Error(path, "has the quantised splats of CoSplat 0.1 and 0.2: export a .ply with those");
  throw Error(path, "is not a splat file: .ply, .spz, .sog, .splat or .glb");
}

}  // namespace

SplatLayout SplatLayoutOf(const std::string& path) {
  if (IsSog(path)) return SplatLayout::kSog;
  if (IsSpz(path)) return SplatLayout::kSpz;
  if (!std::filesystem::is_regular_file(path)) return SplatLayout::kNone;
  if (std::filesystem::path(path).extension() == ".splat") return SplatLayout::kRecords;
  std::string bytes(4, '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), std::streamsize(bytes.size()));
  if (bytes == "glTF") return SplatLayout::kGlb;
  return bytes.starts_with("ply") ? SplatLayout::kPly : SplatLayout::kNone;
}

Gaussians ReadSplats(const std::string& path) {
  Gaussians g = ReadLayout(path);
  WorldOrigin near = OriginNearPoints(g.size(), [&](size_t i) { return g.at(kPosition, i); });
  for (size_t k = 0; k < 3; ++k) near[k] += g.origin[k];
  MoveOrigin(g, near);
  FindDegrees(g);
  return g;
}

void TruncateDegree(int degree, Gaussians& gaussians) {
  if (gaussians.degree <= degree) return;
  Gaussians truncated = gaussians;
  truncated.degree = degree;
  truncated.degrees.clear();
  truncated.values[kColorRest].clear();
  truncated.Resize(gaussians.size());
  for (size_t i = 0; i < gaussians.size(); ++i)
    std::copy_n(
        gaussians.at(kColorRest, i), truncated.width(kColorRest), truncated.at(kColorRest, i));
  gaussians = std::move(truncated);
}

void WriteSceneGlb(const std::string& path, const Gaussians& gaussians, bool truncate_degree) {
  Gaussians turned = gaussians;
  TurnToGltfAxes(turned);
  GlbDocument document;
  document.path = path;
  document.meshes.push_back({"splats",
                             {AddSplats(document, turned, truncate_degree)},
                             {},
                             TurnedToGltfAxes(gaussians.origin)});
  document.scenes.push_back({"scene", {0}});
  document.extensions_used = {kSplatExtension};
  WriteGlb(document);
}

}  // namespace cosplat
