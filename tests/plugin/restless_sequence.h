// RestlessParams as a recording.
#pragma once

#include <string>
#include <vector>

#include "splat/base/npz.h"
#include "tests/plugin/plugin_fixture.h"
#include "tests/support/restless_params.h"

namespace cosplat::test {

// The frames of RestlessParams as a driving sequence, 10 per second.
inline std::string WriteSequence(const char* name, size_t frames) {
  const PluginFiles& files = PluginFiles::Get();
  std::vector<float> expression, joints[4], translation;
  for (size_t f = 0; f < frames; ++f) {
    const FlameParams p = RestlessParams(files.flame, int(f));
    expression.insert(expression.end(), p.expression.begin(), p.expression.end());
    for (size_t j = 0; j < 4; ++j)
      joints[j].insert(joints[j].end(), p.pose[j].begin(), p.pose[j].end());
    translation.insert(translation.end(), p.translation.begin(), p.translation.end());
  }
  Npz npz(files.folder / name);
  npz.Add("expr", {frames, size_t(files.flame.expression_count)}, expression);
  const char* names[4] = {"rot", "neck_rot", "jaw_rot", "eye_rot"};
  for (size_t j = 0; j < 4; ++j) npz.Add(names[j], {frames, 3}, joints[j]);
  npz.Add("tra", {frames, 3}, translation);
  npz.Add("fps", {}, std::vector<float>{10});
  npz.Write(npz.path());
  return npz.path();
}

}  // namespace cosplat::test
