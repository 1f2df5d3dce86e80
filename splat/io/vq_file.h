// Splats with vector-quantised bands of colour, and the file that holds them.
//
// Gaussians -> Quantise (splat/io/vq.h) -> QuantisedSplats -> WriteVqFile -> file -> ReadVqFile ->
// Dequantise -> Gaussians. The file is a zip of .npy arrays (.npz) and a JSON header;
// docs/vq-file.md has it member by member. Source of the method: LightGaussian (Fan et al. 2024).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "splat/base/npz.h"
#include "splat/gaussians.h"

namespace cosplat {

// Bands from 1 on of the splats that have one degree d >= 1, in their order: B = (d+1)^2 - 1
// coefficients of 3DGS's SH.
struct QuantisedBands {
  std::vector<float> kept;      // [P, B, 3] of those that are not quantised
  std::vector<uint16_t> index;  // [Q] row of the codebook of those that are
  std::vector<float> codebook;  // [K, B, 3]
};

struct QuantisedSplats {
  // "scene"; of any other kind, `position` is to be understood by arrays in `more`
  // (avatar/io/avatar_file.h).
  std::string kind = "scene";
  int degree = 0;                    // of the model; no splat's is higher
  std::vector<float> position;       // [N, 3] world units
  std::vector<float> rotation;       // [N, 4] wxyz, unit
  std::vector<float> scale_log;      // [N, 3] log(world units)
  std::vector<float> opacity_logit;  // [N] inverse logistic
  std::vector<float> color_dc;       // [N, 3] coefficient of the constant function
  std::vector<uint8_t> own_degree;   // [N] highest band with a coefficient that is not zero
  std::vector<uint8_t> quantised;    // [N] 1: bands from the codebook of its degree
  std::array<QuantisedBands, kMaxTrainedDegree + 1> bands;  // by own degree; the first is empty

  Npz more;  // further arrays of the file, as they are

  size_t size() const { return opacity_logit.size(); }
};

// The same in full, in 3DGS's SH; bands above a splat's own degree are zero.
Gaussians Dequantise(const QuantisedSplats& splats);

// Positions as 32-bit floats, all else as 16-bit. Atomic. Throws Error when a number does not fit
// or arrays disagree.
void WriteVqFile(const std::string& path, const QuantisedSplats& splats);

// Throws Error naming the member and the value for what is missing, of another shape or version,
// out of range or not finite.
QuantisedSplats ReadVqFile(const std::string& path);

// By the first bytes, whatever the file's name. False where there is no file.
bool IsVqFile(const std::string& path);

}  // namespace cosplat
