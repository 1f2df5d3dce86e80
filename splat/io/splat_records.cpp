#include "splat/io/splat_records.h"

#include <array>
#include <cstring>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/io/packed_values.h"
#include "splat/io/splat_values.h"

namespace cosplat {
namespace {

struct SplatRecord {
  std::array<float, 3> position, scale;
  std::array<uint8_t, 4> color, rotation;
};
static_assert(sizeof(SplatRecord) == 32);
constexpr std::array<uint8_t, 4> kNoRotation{128, 128, 128, 128};  // a quaternion of zero

}  // namespace

Gaussians ReadSplatRecords(const std::string& path, std::vector<std::string>* notes) {
  const std::vector<char> bytes = ReadUnpacked(path);
  if (bytes.empty() || bytes.size() % sizeof(SplatRecord) != 0)
    throw Error(path,
                "has " + std::to_string(bytes.size()) + " bytes, not a multiple of the " +
                    std::to_string(sizeof(SplatRecord)) + " of a .splat record");
  Gaussians g;
  g.basis = Basis::kSh;
  g.Resize(bytes.size() / sizeof(SplatRecord));
  const auto fail = [&](size_t i, const char* field, float value) {
    throw Error(path, "record " + std::to_string(i) + ", " + field, "is " + std::to_string(value));
  };
  for (size_t i = 0; i < g.size(); ++i) {
    SplatRecord record;
    std::memcpy(&record, &bytes[i * sizeof(record)], sizeof(record));
    std::array<double, 4> wxyz;
    for (int k = 0; k < 4; ++k) wxyz[k] = (record.rotation[k] - 128.0) / 128;
    if (record.rotation != kNoRotation) NormalizeByLargest(wxyz);
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = float(wxyz[k]);
    for (int k = 0; k < 3; ++k) {
      if (!std::isfinite(record.position[k])) fail(i, "position", record.position[k]);
      if (!(record.scale[k] >= 0 && std::isfinite(record.scale[k])))
        fail(i, "scale", record.scale[k]);
      g.at(kPosition, i)[k] = record.position[k];
      g.at(kScaleLog, i)[k] = std::log(record.scale[k]);
      g.at(kColorDc, i)[k] = DcOfColor(record.color[k] / 255.0);
    }
    *g.at(kOpacityLogit, i) = LogitOfByteShare(record.color[3] / 255.0);
  }
  SettleSplats(g, notes);
  return g;
}

}  // namespace cosplat
