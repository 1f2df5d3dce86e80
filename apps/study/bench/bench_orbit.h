// `cosplat bench --splats`: how fast a file of splats is drawn from all around.
#pragma once

#include <string>
#include <vector>

#include "apps/study/bench/bench_results.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"

namespace cosplat {

struct OrbitSubject {
  std::string name;  // of the file
  Gaussians gaussians;
  std::vector<Camera> cameras;
};

// Reads a PLY file and stands cameras around its splats, looking level at their middle, -y up, at
// such a distance that the visible ones (but for a thousandth at either end) fill 90 % of the
// pictures' height on average. 1920x1080 px, a 30th of it when `quick`. Throws Error when nothing
// is to be seen.
OrbitSubject LoadOrbit(const std::string& path, bool quick);

struct OrbitResult {
  BenchSeries series;
  Image first;  // picture of the first camera
};
OrbitResult MeasureOrbit(const BenchRun& run, const OrbitSubject& subject);

}  // namespace cosplat
