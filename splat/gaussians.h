// Gaussians as a structure of arrays, for training, rendering and saving.
//
// The same structure holds their gradients and Adam's moments, so that density control and pruning
// reorder all of them alike. For avatars `kPosition` is (delta_u, delta_v, d) on a triangle instead
// of a point (avatar/model/avatar_model.h); the other attributes are the same.
#pragma once

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "splat/base/world_frame.h"
#include "splat/basis.h"
#include "splat/config.h"
#include "splat/device/buffer.h"

namespace cosplat {

enum Attribute {
  kPosition,      // [N, 3] world units
  kRotation,      // [N, 4] wxyz, any norm
  kScaleLog,      // [N, 3] log(world units), standard deviation along the rotated axes
  kOpacityLogit,  // [N, 1] inverse logistic
  kColorDc,       // [N, 3] coefficient of the constant function; colour = 0.5 + K0 * dc + ...
  kColorRest,     // [N, (degree+1)^2 - 1, 3] coefficients of bands >= 1, in 3DGS's order
  kCorrection,    // [N, corrections, kCorrectionNumbers] of avatars (avatar/math/correct.h)
  kAttributeCount
};

constexpr std::array<const char*, kAttributeCount> kAttributeNames{
    "position", "rotation", "scale_log", "opacity_logit", "color_dc", "color_rest", "correction"};

constexpr int kMaxTrainedDegree = 4;

// Numbers of a basis of corrections: offset 3, rotation 4, scale 3, opacity 1, colour 3.
constexpr int kCorrectionNumbers = 14;

struct Gaussians {
  int degree = 0;  // highest band stored
  Basis basis = Basis::kDcsh;
  int corrections = 0;  // bases per Gaussian by which an avatar follows the expression
  // [N] degree of each Gaussian, <= `degree`: coefficients of its higher bands are zero, are not
  // evaluated and get no gradient. Empty if all have `degree`.
  Buffer<uint8_t> degrees;
  // Rendered with a low-pass filter of low_pass_variance, in which the opacity shrinks as the
  // footprint grows (LowPassShare in splat/math/pinhole.h), instead of kBlurVariance without.
  bool antialiased = false;
  // px^2, only if antialiased: ours, or kBlurVariance, with which all other programs train.
  float low_pass_variance = kAntialiasedBlurVariance;
  // [N] only if antialiased: variance of each Gaussian's 3D smoothing filter, world units^2
  // (SmoothScale in splat/math/gaussian.h), which is rendered and is not yet part of scale and
  // opacity. Empty: none.
  Buffer<float> smoothing;
  // What kPosition of a scene is counted from, where its data is far from zero. Copies and files
  // keep it, training passes over it.
  WorldOrigin origin{};
  std::array<Buffer<float>, kAttributeCount> values;

  // As in splat/device/arrays.h.
  template <class Visit, class... Of>
  static void ForEachArray(const Visit& visit, Of&... of) {
    const Gaussians& first = std::get<0>(std::tie(of...));
    for (int a = 0; a < kAttributeCount; ++a)
      visit(kAttributeNames[a], size_t(first.width(a)), of.values[a]...);
    visit("degrees", size_t(1), of.degrees...);
    visit("smoothing", size_t(1), of.smoothing...);
  }

  size_t size() const { return values[kOpacityLogit].size(); }
  // Floats per Gaussian of an attribute.
  int width(int attribute) const;
  float* at(Attribute attribute, size_t i) {
    return values[attribute].data() + i * width(attribute);
  }
  const float* at(Attribute attribute, size_t i) const {
    return values[attribute].data() + i * width(attribute);
  }
  // Resizes to n Gaussians; new ones are zero, with all bands.
  void Resize(size_t n);
  // Makes old Gaussian source[i] the new Gaussian i; a source may appear more than once.
  void Gather(const std::vector<uint32_t>& source);
  // Adds Gaussians of the same layout, with degrees and smoothing if these have them.
  void Append(const Gaussians& more);
  // The same layout, all zero; n: of them.
  Gaussians ZerosLike() const { return ZerosLike(size()); }
  Gaussians ZerosLike(size_t n) const;

  // In a stream's memory; everything above is for host memory only.

  // Copies Gaussians from host memory, which must stay valid until the stream has been waited for.
  void Upload(const Gaussians& from, Stream& stream);
  // Copies to Gaussians in host memory, which get this layout; their values are valid once the
  // stream has been waited for.
  void Download(Gaussians& to, Stream& stream) const;
  // Resizes to n Gaussians of the layout of `other`, or as many as that has, with unspecified
  // values.
  void RefillLike(const Gaussians& other, Stream& stream, size_t n);
  void RefillLike(const Gaussians& other, Stream& stream) {
    RefillLike(other, stream, other.size());
  }
  void FillWithZeros(Stream& stream);

 private:
  void TakeLayout(const Gaussians& from);
};

// Highest band of Gaussian i that has a non-zero coefficient.
int HighestBand(const Gaussians& gaussians, size_t i);

// Sets `degrees` to the highest bands, or empties it if all equal `degree`. For rendering only:
// while training, a coefficient may be zero because its band has just been enabled.
void FindDegrees(Gaussians& gaussians);

// Makes the 3D smoothing filter part of scale and opacity, as files hold them.
void BakeSmoothing(Gaussians& gaussians);

// Counts the positions, which must be points in the world, from another origin.
void MoveOrigin(Gaussians& gaussians, const WorldOrigin& to);
// Whether all positions are such that floats hold them exactly when counted from zero, although
// their origin is not: they have been there, and are coarse.
bool IsRoundedFarAway(const Gaussians& gaussians);

// Allocated bytes, by capacity.
size_t AllocatedBytes(const Gaussians& gaussians);

// Converts the colours to another basis. Where both are spherical harmonics (IsHarmonic), they span
// the same functions, so each coefficient is only rescaled (docs/dcsh.md); otherwise throws Error.
// Files use 3DGS's SH.
void ConvertBasis(Gaussians& gaussians, Basis to);

// Render order of Gaussians with individual degrees.
//
// Kernels evaluate a pack of Gaussians to the highest degree among them. In training order, where
// neighbours in the array are neighbours in space, that is nearly always the highest degree of all.
// Grouped by degree, a trained fox and chair with a mean degree of 1.8 render in 3 to 5 % less time
// (docs/dcsh.md).

// Calls FindDegrees and groups the Gaussians by degree, stably. Returns the previous index of each,
// for reordering associated arrays; empty if all have the same degree.
std::vector<uint32_t> SortByDegree(Gaussians& gaussians);

}  // namespace cosplat
