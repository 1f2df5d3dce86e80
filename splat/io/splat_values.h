// What the numbers of a splat may be, in files of every layout: one rule for all readers and
// writers.
//
// a reader: numbers as stored -> IsSplatNumber, or the file is refused -> SettleSplats -> Gaussians
// -> ReadSplats (splat/io/splat_file.h): LeaveOutUndrawable;
// a writer: Gaussians -> HideWithoutRotation.
//
// Opacities of +-infinity are logits of 1 and 0, a scale of 0 (-infinity as a logarithm) is a
// point: both are valid and become finite. Any other number that is not finite is an error. A
// quaternion of zero has no direction, and a Gaussian of e^40 units has no finite covariance:
// neither is rendered, and programs differ in what they make of them (SplatTransform removes them,
// 3DGS takes zero for no turn), so they are left out and counted.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

// 1 as a float, when it is an opacity again.
constexpr float kOpaqueLogit = 20;
// Squares of e^40 and e^-40 are normal floats.
constexpr float kLargestScaleLog = 40;

// Whether a file may have this value of an attribute.
inline bool IsSplatNumber(Attribute attribute, float value) {
  if (attribute == kOpacityLogit) return !std::isnan(value);
  return std::isfinite(value) || (attribute == kScaleLog && value < 0);
}

// Makes opacities and scales finite, and normalises quaternions so short or long that squares lose
// them. Adds a line to `notes`, if given, that says how many were infinite or zero.
void SettleSplats(Gaussians& gaussians, std::vector<std::string>* notes);

// Removes what cannot be drawn and adds a line that counts it. Throws Error naming `path` if
// nothing is left.
void LeaveOutUndrawable(const std::string& path,
                        Gaussians& gaussians,
                        std::vector<std::string>* notes);

// Adds a line for opacities, sizes or colours whose range is that of another unit: shares or bytes
// in place of logits, lengths in place of logarithms, colours in place of harmonics' coefficients.
void NoteOtherUnits(const Gaussians& gaussians, std::vector<std::string>& notes);

// Gives Gaussians without a direction one and makes them transparent, so that other programs do not
// draw them either. What is not a number stays, for the writer to refuse.
void HideWithoutRotation(Gaussians& gaussians);
void HideWithoutRotation(float* rotation, float& opacity_logit);  // one

// The low-pass filter of anti-aliased Gaussians, as files name it: a number beside the mark that
// they are anti-aliased.
constexpr const char* kLowPassField = "low_pass_variance";
double LowPassNumber(const Gaussians& gaussians);  // 0.1 or 0.3, px^2
// Sets the mark and the filter. Throws Error naming path and field unless `variance` is 0.1 or 0.3.
void SetAntialiased(const std::string& path, double variance, Gaussians& gaussians);

}  // namespace cosplat
