#include "splat/io/splat_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/glb.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_primitive.h"
#include "splat/io/splat_records.h"
#include "splat/io/spz.h"
#include "splat/io/vq_file.h"

namespace cosplat {
namespace {

Gaussians ReadQuantised(const std::string& path) {
  const QuantisedSplats splats = ReadVqFile(path);
  if (splats.kind != "scene")
    throw Error(path, "splats.json", "kind is '" + splats.kind + "', expected 'scene'");
  return Dequantise(splats);
}

// Turned back to the axes that WriteSceneGlb was given.
Gaussians ReadSceneGlb(const std::string& path) {
  const GlbDocument document = ReadGlb(path, {kSplatExtension});
  Gaussians g = ReadSplatPrimitive(document, FindSplats(document));
  TurnToGltfAxes(g);  // its own inverse
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
    case SplatLayout::kQuantised:
      return ReadQuantised(path);
    case SplatLayout::kNone:
      break;
  }
  ReadFile(path);  // says so if there is none
  throw Error(path, "is not a splat file: .ply, .spz, .sog, .splat, .glb or quantised");
}

}  // namespace

SplatLayout SplatLayoutOf(const std::string& path) {
  if (IsVqFile(path)) return SplatLayout::kQuantised;
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
  document.meshes.push_back({"splats", {AddSplats(document, turned, truncate_degree)}, {}});
  document.scenes.push_back({"scene", {0}});
  document.extensions_used = {kSplatExtension};
  WriteGlb(document);
}

}  // namespace cosplat
