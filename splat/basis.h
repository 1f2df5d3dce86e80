// The colour bases by name. Both span the same functions; see docs/dcsh.md.
#pragma once

#include <string>

namespace cosplat {

enum class Basis { kDcsh, kSh };
std::string ToString(Basis basis);
Basis BasisFromString(const std::string& text);  // Error on anything but "dcsh" or "sh"

constexpr int CoefficientCount(int degree) { return (degree + 1) * (degree + 1); }

}  // namespace cosplat
