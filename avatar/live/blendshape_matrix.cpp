#include "avatar/live/blendshape_matrix.h"

#include <algorithm>
#include <cmath>

#include "avatar/live/guard.h"
#include "splat/base/error.h"
#include "splat/base/npz.h"

namespace cosplat {
namespace {

static_assert(kMaxMapped == kMaxParameter);

// columns: -1 for any.
const NpyArray& ReadRows(const Npz& npz, const char* name, long columns) {
  const NpyArray& array = npz.Get(name, {long(kArkitBlendshapes), columns});
  const size_t width = array.shape[1];
  if (width == 0 || width > kMaxExpressions)
    throw Error(npz.path(), name, "has " + std::to_string(width) + " columns");
  for (size_t column = 0; column < width; ++column) {
    double max = 0;
    for (size_t row = 0; row < kArkitBlendshapes; ++row)
      max += std::abs(array.values[row * width + column]);
    if (!(max <= kMaxMapped))
      throw Error(npz.path(),
                  name,
                  "absolute values of column " + std::to_string(column) + " add up to " +
                      std::to_string(max) + ", at most " + std::to_string(int(kMaxMapped)) +
                      " is allowed");
  }
  return array;
}

// Copies rows to the columns of the map that begin at `first`.
void CopyRows(const NpyArray& rows, size_t first, BlendshapeMap& map) {
  const size_t width = rows.shape[1];
  for (size_t r = 0; r < kArkitBlendshapes; ++r)
    std::copy_n(&rows.values[r * width], width, &map.matrix[r * map.offset.size() + first]);
}

}  // namespace

BlendshapeMap ReadBlendshapeMatrix(const std::string& path) {
  const Npz npz = Npz::Read(path);
  const NpyArray& expression = ReadRows(npz, "expression", -1);
  const size_t expressions = expression.shape[1];
  BlendshapeMap map;
  map.names.assign(kArkitNames.begin(), kArkitNames.end());
  map.min.assign(kArkitBlendshapes, 0.0f);
  map.max.assign(kArkitBlendshapes, 1.0f);
  map.offset.assign(expressions + kMappedTurns, 0.0f);
  map.matrix.assign(kArkitBlendshapes * map.offset.size(), 0.0f);
  CopyRows(expression, 0, map);
  const char* const joints[] = {"jaw", "left_eye", "right_eye"};
  for (size_t j = 0; j < 3; ++j)
    if (npz.Has(joints[j])) CopyRows(ReadRows(npz, joints[j], 3), expressions + 3 * j, map);
  return map;
}

}  // namespace cosplat
