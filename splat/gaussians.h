// The Gaussians as a structure of arrays: what is trained, rendered and saved.
//
// The same structure holds their gradients and Adam's moments, so that density control and pruning
// move all of them alike. For avatars `kPosition` is (delta_u, delta_v, d) on a triangle instead of
// a point (avatar/model/avatar_model.h); everything else means the same.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/basis.h"
#include "splat/device/buffer.h"

namespace cosplat {

enum Attribute {
  kPosition,      // [N, 3] world units
  kRotation,      // [N, 4] wxyz, any norm
  kScaleLog,      // [N, 3] log(world units), standard deviation along the rotated axes
  kOpacityLogit,  // [N, 1] inverse logistic
  kColorDc,       // [N, 3] coefficient of the constant function; colour = 0.5 + K0 * dc + ...
  kColorRest,     // [N, (degree+1)^2 - 1, 3] coefficients of bands 1.., 3DGS's order
  kAttributeCount
};

constexpr int kMaxTrainedDegree = 4;

struct Gaussians {
  int degree = 0;  // highest band stored
  Basis basis = Basis::kDcsh;
  // [N] each Gaussian's own degree, <= `degree`: coefficients of its higher bands are zero, are not
  // evaluated and get no gradient. Empty: `degree` for all.
  Buffer<uint8_t> degrees;
  std::array<Buffer<float>, kAttributeCount> values;

  size_t size() const { return values[kOpacityLogit].size(); }
  // Floats per Gaussian of an attribute.
  int width(int attribute) const;
  float* at(Attribute attribute, size_t i) {
    return values[attribute].data() + i * width(attribute);
  }
  const float* at(Attribute attribute, size_t i) const {
    return values[attribute].data() + i * width(attribute);
  }
  // n Gaussians of this degree; new ones are zero, with all bands.
  void Resize(size_t n);
  // Keeps Gaussian source[0], source[1], ... in this order; a source may appear more than once.
  void Gather(const std::vector<uint32_t>& source);
  // The same layout, all zero.
  Gaussians ZerosLike() const;

  // In a stream's memory; all of the above is the host's alone.

  // Takes over Gaussians of the host's memory, which must stay until the stream was waited for.
  void Upload(const Gaussians& from, Stream& stream);
  // To Gaussians of the host's memory, which get this layout; they are there when the stream was
  // waited for.
  void Download(Gaussians& to, Stream& stream) const;
  // Room for the same layout; any values.
  void RefillLike(const Gaussians& other, Stream& stream);
  void FillWithZeros(Stream& stream);
};

// Highest band of Gaussian i with a coefficient that is not zero.
int HighestBand(const Gaussians& gaussians, size_t i);

// Sets `degrees` to that, or to nothing where it is `degree` for all: for Gaussians that are to be
// drawn. (In training, zero may be where a band begins.)
void FindDegrees(Gaussians& gaussians);

// Bytes that they hold, by capacity.
size_t HeldBy(const Gaussians& gaussians);

// The same colours in another basis: where they are spherical harmonics (IsHarmonic), both span the
// same functions, so each coefficient is only multiplied (docs/dcsh.md); Error where not. Files
// hold 3DGS's SH.
void ConvertBasis(Gaussians& gaussians, Basis to);

// The order to draw Gaussians in that have degrees of their own.
//
// Kernels evaluate a pack of Gaussians to the highest degree among them. In the order that training
// leaves, neighbours in space, that is nearly always the highest of all; with those of one degree
// together, drawing a trained fox and chair at a mean degree of 1.8 takes 3 to 5 % less time
// (docs/dcsh.md).

// FindDegrees, and puts Gaussians of one degree together, otherwise as they were. Returns which
// each was before, for what lies beside them; nothing where all have one degree.
std::vector<uint32_t> SortByDegree(Gaussians& gaussians);

}  // namespace cosplat
