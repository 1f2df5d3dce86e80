// The colour bases by name; see docs/dcsh.md.
#pragma once

#include <array>
#include <string>

namespace cosplat {

enum class Basis {
  kDcsh,
  kSh,            // 3DGS's
  kDcshReleased,  // with the constants of DCSHARP's released code, errors included
  kDcshLiteral    // the published formula with its arctan(y/x), for comparison
};
constexpr std::array<const char*, 4> kBasisNames{
    "dcsh", "sh", "dcsh-released", "dcsh-literal"};  // in the order of Basis
inline std::string ToString(Basis basis) { return kBasisNames[size_t(basis)]; }
// Throws Error, naming `file` and `field`, for an unknown name.
Basis BasisFromString(const std::string& text,
                      const std::string& file = "",
                      const std::string& field = "basis");

// The literal formula folds every direction onto the half space x >= 0 (`Fold` in
// splat/math/dcsh.h).
constexpr bool FoldsDirection(Basis basis) { return basis == Basis::kDcshLiteral; }

// Whether all colours up to this degree are spherical harmonics, so that they can be converted to
// the other bases and stored in files.
constexpr bool IsHarmonic(Basis basis, int degree) { return degree == 0 || !FoldsDirection(basis); }

constexpr int CoefficientCount(int degree) { return (degree + 1) * (degree + 1); }

}  // namespace cosplat
