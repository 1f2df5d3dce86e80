#include <cmath>

#include "avatar/io/avatar_file.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr const char* kKind = "avatar";

std::vector<int32_t> Triangles(const QuantisedSplats& splats, size_t faces) {
  const NpyArray& array = splats.more.Get("triangle", {long(splats.size())});
  std::vector<int32_t> triangles;
  for (size_t i = 0; i < array.size(); ++i) {
    const double value = array.values[i];
    if (!(value >= 0 && value < double(faces) && value == std::floor(value)))
      throw Error(splats.more.path(),
                  "triangle",
                  "number " + std::to_string(i) + " is " + std::to_string(value) +
                      ", expected one of the mesh's " + std::to_string(faces));
    triangles.push_back(int32_t(value));
  }
  return triangles;
}

}  // namespace

void AddEmbedding(const Embedding& embedding, QuantisedSplats& splats) {
  const size_t n = splats.size();
  std::vector<float> barycentric;
  for (const auto& [u, v] : embedding.barycentric) barycentric.insert(barycentric.end(), {u, v});
  splats.kind = kKind;
  const std::vector<int32_t> triangle(embedding.triangle.begin(), embedding.triangle.end());
  splats.more.Add("triangle", {n}, triangle);
  splats.more.Add("barycentric", {n, 2}, barycentric);
}

void ReadQuantisedAvatar(const std::string& path, AvatarModel& model) {
  const QuantisedSplats splats = ReadVqFile(path);
  if (splats.kind != kKind)
    throw Error(path, "splats.json", "kind is '" + splats.kind + "', expected 'avatar'");
  const std::vector<int32_t> triangles = Triangles(splats, model.mesh.faces.size());
  const NpyArray& barycentric = splats.more.Get("barycentric", {long(splats.size()), 2});
  for (size_t i = 0; i < barycentric.size(); ++i)
    if (!std::isfinite(float(barycentric.values[i])))
      throw Error(path, "barycentric", "number " + std::to_string(i) + " is not finite");
  model.embedding.triangle = triangles;
  model.embedding.barycentric.clear();
  for (size_t i = 0; i < splats.size(); ++i)
    model.embedding.barycentric.push_back(
        {float(barycentric.values[2 * i]), float(barycentric.values[2 * i + 1])});
  model.gaussians = Dequantise(splats);
  model.correction_map = {};
}

}  // namespace cosplat
