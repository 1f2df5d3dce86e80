// What both layouts of splat PLY files share: the colour bands' properties and the degree.
#pragma once

#include <string>
#include <vector>

#include "splat/gaussians.h"
#include "splat/io/ply_reader.h"

namespace cosplat {

// A property of the file and where it lives in Gaussians.
struct PlyColumn {
  std::string name;
  Attribute attribute;
  int component;
};

// f_rest_*, channel-major, of so many coefficients per channel.
std::vector<PlyColumn> RestColumns(int coefficients);

// From the number of f_rest_* of the element that is being read; Error when no degree has so many.
int DegreeOf(const PlyReader& reader);

}  // namespace cosplat
