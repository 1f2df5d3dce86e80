#include "splat/io/packed_values.h"

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/io/splat_file.h"

namespace cosplat {

int NormalizeByLargest(std::array<double, 4>& q) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(norm > 1e-8)) {
    q = {1, 0, 0, 0};
    return 0;
  }
  int largest = 0;
  for (int k = 1; k < 4; ++k)
    if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
  const double factor = (q[largest] < 0 ? -1 : 1) / norm;
  for (double& component : q) component *= factor;
  return largest;
}

void CheckForSplatFile(const std::string& path, const Gaussians& g) {
  if (g.basis != Basis::kSh)
    throw Error(path, "basis", "is " + ToString(g.basis) + ", splat files hold sh");
  if (g.size() == 0) throw Error(path, "there are no Gaussians to write");
  if (g.degree > kMaxSplatFileDegree)
    throw Error(path,
                "degree",
                "is " + std::to_string(g.degree) +
                    ", other programs read degrees up to 3: request truncation to drop higher "
                    "bands");
  constexpr std::array<const char*, kAttributeCount> kNames{
      "position", "rotation", "scale", "opacity", "color_dc", "color_rest", "correction"};
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < g.values[a].size(); ++i)
      if (!std::isfinite(g.values[a][i]))
        throw Error(
            path, Format("Gaussian {}, {}", i / size_t(g.width(a)), kNames[a]), "is not finite");
}

void CheckSplatCount(const std::string& path,
                     const std::string& field,
                     uint64_t count,
                     uint64_t file_bytes) {
  constexpr uint64_t kAlwaysAllowed = 1 << 16;
  if (count > kAlwaysAllowed && count > file_bytes)
    throw Error(path,
                field,
                Format("is {}, more splats than the file's {} bytes can hold", count, file_bytes));
}

}  // namespace cosplat
