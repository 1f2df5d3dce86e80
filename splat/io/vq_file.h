// Splats with vector-quantised colour bands, and their file format.
//
// Gaussians -> Quantise (splat/io/vq.h) -> QuantisedSplats -> WriteVqFile -> file -> ReadVqFile ->
// Dequantise -> Gaussians. The file is a zip of .npy arrays (.npz) and a JSON header;
// docs/vq-file.md documents each member. Source of the method: LightGaussian (Fan et al. 2024).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "splat/base/npz.h"
#include "splat/gaussians.h"

namespace cosplat {

// Bands 1 and up of the splats of one degree d >= 1, in their order: B = (d+1)^2 - 1 coefficients
// of 3DGS's SH.
struct QuantisedBands {
  std::vector<float> kept;      // [P, B, 3] of the splats that are not quantised
  std::vector<uint16_t> index;  // [Q] codebook row of those that are
  std::vector<float> codebook;  // [K, B, 3]
};

struct QuantisedSplats {
  // "scene"; for any other kind, `position` is to be interpreted with arrays in `more`
  // (avatar/io/avatar_file.h).
  std::string kind = "scene";
  int degree = 0;                    // of the model; no splat has a higher one
  bool antialiased = false;          // Gaussians::antialiased
  std::vector<float> position;       // [N, 3] world units
  std::vector<float> rotation;       // [N, 4] wxyz, unit
  std::vector<float> scale_log;      // [N, 3] log(world units)
  std::vector<float> opacity_logit;  // [N] inverse logistic
  std::vector<float> color_dc;       // [N, 3] coefficient of the constant function
  std::vector<uint8_t> own_degree;   // [N] highest band with a non-zero coefficient
  std::vector<uint8_t> quantised;    // [N] 1: bands from the codebook of its degree
  std::array<QuantisedBands, kMaxTrainedDegree + 1> bands;  // by own degree; the first is empty

  Npz more;  // other arrays of the file, unchanged

  size_t size() const { return opacity_logit.size(); }
};

// The full Gaussians, in 3DGS's SH; bands above a splat's own degree are zero.
Gaussians Dequantise(const QuantisedSplats& splats);

// Stores positions as 32-bit and the other attributes as 16-bit floats. Atomic. Throws Error if a
// number does not fit or arrays are inconsistent.
void WriteVqFile(const std::string& path, const QuantisedSplats& splats);

// Throws Error naming the member and the value if something is missing, has another shape or
// version, or is out of range or not finite.
QuantisedSplats ReadVqFile(const std::string& path);

// Decided by the first bytes, regardless of the file's name. False if there is no file.
bool IsVqFile(const std::string& path);

}  // namespace cosplat
