#include "splat/io/ply_columns.h"

namespace cosplat {

std::vector<PlyColumn> RestColumns(int coefficients) {
  std::vector<PlyColumn> columns;
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < coefficients; ++k)
      columns.push_back({"f_rest_" + std::to_string(columns.size()), kColorRest, 3 * k + c});
  return columns;
}

int DegreeOf(const PlyReader& reader) {
  int rest = 0;
  for (const std::string& name : reader.properties()) rest += name.starts_with("f_rest_");
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree)
    if (rest == 3 * (CoefficientCount(degree) - 1)) return degree;
  reader.Fail("has " + std::to_string(rest) + " properties f_rest_*, expected 0, 9, 24, 45 or 72");
}

}  // namespace cosplat
