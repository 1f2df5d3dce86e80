// Untrained corrections (avatar/math/correct.h), for tests.
#pragma once

#include "avatar/model/corrections.h"
#include "splat/base/rng.h"

namespace cosplat::test {

// The same avatar with `count` random bases of corrections.
inline AvatarModel WithCorrections(AvatarModel avatar, const FlameModel& flame, int count) {
  Rng rng{9};
  CorrectionMap& map = avatar.correction_map;
  map.mean.assign(size_t(flame.expression_count) + kMinCorrectionInputs, 0.1f);
  for (size_t i = 0; i < size_t(count) * map.mean.size(); ++i)
    map.matrix.push_back(0.3f * rng.Normal());
  map.min.assign(size_t(count), -1.0f);
  map.max.assign(size_t(count), 1.0f);
  avatar.gaussians.corrections = count;
  Buffer<float>& bases = avatar.gaussians.values[kCorrection];
  bases.resize(avatar.size() * size_t(avatar.gaussians.width(kCorrection)));
  for (float& b : bases) b = 0.02f * rng.Normal();
  return avatar;
}

}  // namespace cosplat::test
