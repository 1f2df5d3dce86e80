// Numeric arrays out of a parsed pickle: numpy arrays and scalars, numbers, scipy's csc_matrix
// (made dense) and chumpy's wrappers around any of them.
#pragma once

#include <string>

#include "flame/io/pickle.h"
#include "splat/base/npz.h"

namespace cosplat {

// `file` and `name` are for errors. Throws Error when `value` is no array of numbers, or when its
// shape, type and data disagree.
NpyArray ArrayOf(const std::string& file, const std::string& name, const PickleValue& value);

}  // namespace cosplat
