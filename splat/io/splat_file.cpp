#include "splat/io/splat_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <vector>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/io/glb.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_primitive.h"
#include "splat/io/splat_records.h"
#include "splat/io/splat_values.h"
#include "splat/io/spz.h"

namespace cosplat {
namespace {

WorldOrigin TurnedToGltfAxes(const WorldOrigin& p) { return {p[0], 0 - p[1], 0 - p[2]}; }

// Turned back to the axes that WriteSceneGlb was given.
Gaussians ReadSceneGlb(const std::string& path, std::vector<std::string>* notes) {
  const GlbDocument document = ReadGlb(path, {kSplatExtension});
  const GlbPrimitive& splats = FindSplats(document);
  Gaussians g = ReadSplatPrimitive(document, splats, notes);
  TurnToGltfAxes(g);  // its own inverse
  for (const GlbMesh& mesh : document.meshes)
    for (const GlbPrimitive& primitive : mesh.primitives)
      if (&primitive == &splats) g.origin = TurnedToGltfAxes(mesh.translation);
  return g;
}

// In lower case and without gzip's ending.
std::string EndingOf(const std::string& path) {
  std::string name = LowerCase(std::filesystem::path(path).filename().string());
  if (name.ends_with(".gz")) name.resize(name.size() - 3);
  return std::filesystem::path(name).extension().string();
}

Gaussians ReadLayout(const std::string& path, std::vector<std::string>* notes) {
  switch (SplatLayoutOf(path)) {
    case SplatLayout::kPly:
      return ReadPly(path, notes);
    case SplatLayout::kSpz:
      return ReadSpz(path, notes);
    case SplatLayout::kSog:
      return ReadSog(path);
    case SplatLayout::kRecords:
      return ReadSplatRecords(path, notes);
    case SplatLayout::kGlb:
      return ReadSceneGlb(path, notes);
    case SplatLayout::kNone:
      break;
  }
  const std::vector<char> bytes = ReadFile(path);  // says so if there is none
  // The name of a ZIP archive's first member follows its header of 30 bytes.
  if (std::string_view(bytes.data(), bytes.size()).substr(0, 41).ends_with("splats.json"))
    throw Error(path, "has the quantised splats of CoSplat 0.1 and 0.2: export a .ply with those");
  const std::string other = OtherKindOf(path);
  throw Error(path,
              other.empty() ? "is not a splat file: .ply, .spz, .sog, .splat or .glb" : other);
}

}  // namespace

std::string OtherKindOf(const std::string& path) {
  constexpr size_t kBegin = 64;
  const std::string content = OtherContent(FirstBytes(path, kBegin));
  if (!content.empty()) return content;
  const std::string ending = EndingOf(path);
  for (const char* other : {".ksplat", ".lcc", ".lcc2", ".rad"})
    if (ending == other)
      return "is a " + ending + " file, which is not read: SplatTransform makes a .ply of it";
  if (std::filesystem::path(path).filename() == "lod-meta.json")
    return "lists SOG files at several levels of detail: give one of their meta.json";
  return "";
}

SplatLayout SplatLayoutOf(const std::string& path) {
  if (IsSog(path)) return SplatLayout::kSog;
  if (!std::filesystem::is_regular_file(path)) return SplatLayout::kNone;
  if (IsSpz(path)) return SplatLayout::kSpz;
  const std::string bytes = FirstBytes(path, 4);
  if (bytes == "glTF") return SplatLayout::kGlb;
  if (bytes == "ply\n" || bytes == "ply\r") return SplatLayout::kPly;
  return EndingOf(path) == ".splat" && OtherKindOf(path).empty() ? SplatLayout::kRecords
                                                                 : SplatLayout::kNone;
}

Gaussians ReadSplats(const std::string& path, std::vector<std::string>* notes) {
  Gaussians g = ReadLayout(path, notes);
  if (g.size() == 0) throw Error(path, "has no splats");
  if (notes) NoteOtherUnits(g, *notes);
  LeaveOutUndrawable(path, g, notes);
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
