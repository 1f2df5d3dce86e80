// Initial Gaussians of a run.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// One Gaussian per point: isotropic, its standard deviation the root mean square distance to the
// three nearest points; opacity 0.1; the point's colour (3DGS). points: [P, 3]; colors: [P, 3].
// unit: SmallUnit of the scene. Throws Error if there is no point or one is not finite.
Gaussians InitializeFromPoints(const std::vector<float>& points,
                               const std::vector<uint8_t>& colors,
                               int degree,
                               Basis basis,
                               float unit = 1);

// Keeps at most `max` points, evenly subsampled in their order.
void LimitPoints(size_t max, std::vector<float>& points, std::vector<uint8_t>& colors);

// The point closest to all optical axes, in the least-squares sense.
std::array<float, 3> FocusPoint(const std::vector<Camera>& cameras);

// Appends `count` points of random colour, uniform in the cube [-1.3, 1.3]^3 around the origin
// (3DGS, for synthetic scenes) or, if the cameras do not surround it, in a cube around their focus.
// Where the cameras lie on a sphere, as those of synthetic scenes do, its middle is such an origin;
// where they are less than 1 or more than 100 away, 1.3 is in units of the power of ten below.
void RandomPoints(const std::vector<Camera>& cameras,
                  size_t count,
                  Rng& rng,
                  std::vector<float>& points,
                  std::vector<uint8_t>& colors);

// Finds initial points by a space sweep, for a scene that has none: points where its images agree.
// Source: Collins 1996, *A space-sweep approach to true multi-image matching*, applied per pixel.
//
// Casts `rays` rays through random pixels and appends the points found to `points` ([P, 3], world)
// and `colors` ([P, 3]). Along each ray, the depth is chosen at which neighbouring images show the
// most similar 3x3 pixels; rays on which no depth stands out, and pixels with alpha below one half,
// yield no point. Depths range from a fifth of the distance between a camera and the common focus
// point to infinity, evenly spaced in inverse depth. Results are bit-identical for any thread
// count.
void SweepPoints(const std::vector<TrainFrame>& frames,
                 size_t rays,
                 Rng& rng,
                 std::vector<float>& points,
                 std::vector<uint8_t>& colors);

}  // namespace cosplat
