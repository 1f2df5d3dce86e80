// The CPU rasteriser: finite differences, thread counts, instruction sets, failure modes.
#include "splat/render/rasterizer.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "splat/base/error.h"
#include "splat/base/rng.h"
#include "splat/math/blend.h"
#include "splat/math/dcsh.h"
#include "splat/math/pinhole.h"
#include "splat/render/kernels/project.h"
#include "splat/render/view_splats.h"
#include "tests/support/same_bits.h"

namespace cosplat {
namespace {

using test::SameBits;

Camera TestCamera(int width, int height) {
  Camera c;
  c.width = width;
  c.height = height;
  c.fx = c.fy = float(width);
  c.cx = width * 0.47f;
  c.cy = height * 0.52f;
  c.translation = {0.05f, -0.02f, 3.0f};
  return c;
}

Gaussians RandomGaussians(size_t n, int degree, uint64_t seed, float size = 0.12f) {
  Rng rng{seed};
  Gaussians g;
  g.degree = degree;
  g.Resize(n);
  for (size_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = rng.Normal() * 0.5f;
      g.at(kScaleLog, i)[k] = std::log(size) + 0.4f * rng.Normal();
      g.at(kColorDc, i)[k] = rng.Normal();
    }
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rng.Normal();
    g.at(kOpacityLogit, i)[0] = rng.Normal();
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.1f * rng.Normal();
  }
  return g;
}

// With a 3D smoothing filter about as large as the Gaussians.
Gaussians Antialiased(Gaussians g) {
  Rng rng{23};
  g.antialiased = true;
  for (size_t i = 0; i < g.size(); ++i)
    g.smoothing.push_back(0.02f * rng.Uniform() * std::exp(2 * g.at(kScaleLog, i)[1] + 4));
  return g;
}

struct Rendering {
  RenderedImage image;
  Gaussians gradients;
  Buffer<float> screen;
};

RenderSettings Settings(int degree) { return {{0.3f, 0.5f, 0.7f}, degree}; }

Rendering Render(const Gaussians& g, const Camera& camera, bool backward = true) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  Rendering r;
  rasterizer->Forward(ViewOf(g), g.basis, camera, Settings(g.degree), r.image, *tape);
  if (!backward) return r;
  Buffer<float> d(r.image.color.size());
  for (size_t i = 0; i < d.size(); ++i) d[i] = 0.5f + 0.5f * std::sin(0.37f * float(i));
  r.gradients = g.ZerosLike();
  rasterizer->Backward(ViewOf(g), r.image, d, *tape, GradientViewOf(r.gradients, r.screen));
  return r;
}

// A plain double-precision renderer from the same formulas: no tiles, no lists, no SIMD.
// `accepted`: which (pixel, splat) pairs count, recorded when empty and replayed when not.
// Replaying makes the image smooth in everything: no splat's rim crosses a pixel.
std::vector<double> ReferencePixels(const Gaussians& g,
                                    const Camera& camera,
                                    std::vector<bool>* accepted = nullptr) {
  const bool replay = accepted && !accepted->empty();
  size_t pair = 0;
  using namespace math;
  struct Splat {
    double depth, x, y, opacity;
    PowerForm<double> form;
    Vec3<double> color;
  };
  Pinhole<double> c;
  for (int i = 0; i < 9; ++i) c.rotation.m[i] = camera.rotation[i];
  c.translation = {camera.translation[0], camera.translation[1], camera.translation[2]};
  c.fx = camera.fx, c.fy = camera.fy, c.cx = camera.cx, c.cy = camera.cy;
  c.width = camera.width, c.height = camera.height;
  const auto center = camera.Center();
  std::vector<Splat> splats;
  for (size_t i = 0; i < g.size(); ++i) {
    const float *m = g.at(kPosition, i), *q = g.at(kRotation, i), *s = g.at(kScaleLog, i);
    const Vec3<double> position{m[0], m[1], m[2]};
    const Vec3<double> p = ToCamera(c, position);
    if (p.z <= kNearPlane) continue;
    Vec3<double> scale{std::exp(double(s[0])), std::exp(double(s[1])), std::exp(double(s[2]))};
    double opacity = Sigmoid(double(g.at(kOpacityLogit, i)[0]));
    if (g.antialiased) {
      const auto smoothed = SmoothScale(scale, double(g.smoothing[i]));
      scale = smoothed.scale;
      opacity *= smoothed.share;
    }
    const auto cov3 = Covariance(Quat<double>{q[0], q[1], q[2], q[3]}, scale);
    const double variance = g.antialiased ? kAntialiasedBlurVariance : kBlurVariance;
    const auto cov = ProjectCovariance(c, p, cov3, variance);
    if (g.antialiased) opacity *= LowPassShare(ProjectCovariance(c, p, cov3, 0.0), variance);
    const auto conic = Conic(cov);
    const auto xy = ProjectPoint(c, p);
    std::vector<double> dc(g.at(kColorDc, i), g.at(kColorDc, i) + 3);
    std::vector<double> rest(g.at(kColorRest, i), g.at(kColorRest, i) + g.width(kColorRest));
    const auto u = Normalize(position - Vec3<double>{center[0], center[1], center[2]});
    splats.push_back({p.z,
                      xy.x,
                      xy.y,
                      opacity,
                      {-0.5 * conic.xx, -conic.xy, -0.5 * conic.yy},
                      EvaluateColor<3>(u, BasisConstants(g.basis), dc.data(), rest.data())});
  }
  std::stable_sort(splats.begin(), splats.end(), [](const Splat& a, const Splat& b) {
    return a.depth < b.depth;
  });
  const size_t plane = size_t(camera.width) * camera.height;
  std::vector<double> out(3 * plane);
  const auto bg = Settings(3).background;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      BlendState<double> state{1, {0, 0, 0}};
      for (const Splat& s : splats) {
        const double power = PowerAt(s.form, x + 0.5 - s.x, y + 0.5 - s.y);
        bool accept = Accepts(power, RejectBelow(s.opacity), state.transmittance);
        if (replay) accept = (*accepted)[pair++];
        if (accepted && !replay) accepted->push_back(accept);
        BlendBehind(AlphaOf(s.opacity, accept ? Exp(power) : 0.0), s.color, state);
      }
      const size_t i = size_t(y) * camera.width + x;
      out[i] = state.color.x + state.transmittance * bg[0];
      out[plane + i] = state.color.y + state.transmittance * bg[1];
      out[2 * plane + i] = state.color.z + state.transmittance * bg[2];
    }
  return out;
}

void ExpectEqualsThePlainReference(const Gaussians& g) {
  const Camera camera = TestCamera(70, 53);  // not a multiple of the tile
  const Rendering r = Render(g, camera, false);
  const std::vector<double> expected = ReferencePixels(g, camera);
  int flips = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const double error = std::abs(r.image.color[i] - expected[i]);
    // Inside: float against double. A splat at the edge of visibility may flip: at most one grey
    // level.
    if (error > 2e-5) ++flips;
    EXPECT_LT(error, 1.5 / 255);
  }
  EXPECT_LT(flips, int(expected.size() / 200));
}

TEST(Rasterizer, EqualsThePlainReference) {
  ExpectEqualsThePlainReference(RandomGaussians(300, 3, 7));
  ExpectEqualsThePlainReference(Antialiased(RandomGaussians(300, 3, 7, 0.03f)));
}

void ExpectGradientsMatchFiniteDifferences(Gaussians g) {
  const Camera camera = TestCamera(48, 40);
  const Rendering r = Render(g, camera);
  std::vector<bool> accepted;
  ReferencePixels(g, camera, &accepted);
  const auto loss = [&](const Gaussians& at) {
    const auto pixels = ReferencePixels(at, camera, &accepted);
    double sum = 0;
    for (size_t i = 0; i < pixels.size(); ++i)
      sum += pixels[i] * (0.5 + 0.5 * std::sin(0.37f * float(i)));
    return sum;
  };
  double dot = 0, norm_a = 0, norm_n = 0;
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t k = 0; k < g.values[a].size(); k += (a == kColorRest ? 7 : 1)) {
      const float value = g.values[a][k], h = 1e-3f;
      g.values[a][k] = value + h;
      const double up = loss(g);
      g.values[a][k] = value - h;
      const double down = loss(g);
      g.values[a][k] = value;
      const double numeric = (up - down) / (2 * double(h)), analytic = r.gradients.values[a][k];
      // Second order in h, and float sums over 1,920 pixels.
      EXPECT_NEAR(analytic, numeric, 1e-3 * (std::abs(numeric) + 1))
          << "attribute " << a << " at " << k;
      dot += numeric * analytic;
      norm_a += analytic * analytic;
      norm_n += numeric * numeric;
    }
  EXPECT_GT(dot / std::sqrt(norm_a * norm_n), 0.999999);
  EXPECT_NEAR(std::sqrt(norm_a / norm_n), 1, 1e-4);
}

TEST(Rasterizer, GradientsMatchFiniteDifferences) {
  ExpectGradientsMatchFiniteDifferences(RandomGaussians(12, 3, 3, 0.3f));
}

TEST(Rasterizer, GradientsOfTheFiltersMatchFiniteDifferences) {
  ExpectGradientsMatchFiniteDifferences(Antialiased(RandomGaussians(12, 3, 3, 0.1f)));
}

// What anti-aliasing is for: a Gaussian far below a pixel adds what its area adds, and not the
// filter's own.
TEST(Rasterizer, AnAntialiasedGaussianKeepsItsSumAtAnyDistance) {
  const auto light_at = [](float distance, bool antialiased) {
    Gaussians g = RandomGaussians(1, 0, 1);
    g.antialiased = antialiased;
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, 0)[k] = k == 2 ? distance - 3 : 0;
      g.at(kScaleLog, 0)[k] = std::log(0.1f);
    }
    *g.at(kOpacityLogit, 0) = 3;
    double sum = 0;
    for (const float t : Render(g, TestCamera(64, 64), false).image.transmittance) sum += 1 - t;
    return sum * double(distance) * distance;
  };
  // In px: standard deviations of 2.1 and 0.53. Below 1/255 contributions are dropped.
  EXPECT_NEAR(light_at(12, true) / light_at(3, true), 1, 0.05);
  EXPECT_GT(light_at(12, false) / light_at(3, false), 1.5);
}

TEST(Rasterizer, BakedSmoothingShowsTheSameImage) {
  Gaussians g = Antialiased(RandomGaussians(300, 2, 7, 0.05f));
  const Camera camera = TestCamera(70, 53);
  const Rendering expected = Render(g, camera, false);
  BakeSmoothing(g);
  EXPECT_TRUE(g.smoothing.empty());
  const Rendering baked = Render(g, camera, false);
  int flips = 0;
  for (size_t i = 0; i < baked.image.color.size(); ++i) {
    const float error = std::abs(baked.image.color[i] - expected.image.color[i]);
    EXPECT_LT(error, 1.5 / 255);  // a splat at the edge of visibility
    flips += error > 2e-5f;
  }
  EXPECT_LT(flips, int(baked.image.color.size() / 200));
}

TEST(Rasterizer, BitsDoNotDependOnThreads) {
  const Gaussians g = RandomGaussians(9000, 2, 11, 0.05f);
  const Camera camera = TestCamera(150, 100);
  Rendering first;
  for (const int threads : {1, 2, 3, 7}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Rendering r = Render(g, camera);
    if (threads == 1) {
      first = r;
      continue;
    }
    EXPECT_TRUE(SameBits(r.image.color, first.image.color)) << threads;
    for (int a = 0; a < kAttributeCount; ++a)
      EXPECT_TRUE(SameBits(r.gradients.values[a], first.gradients.values[a]))
          << threads << ' ' << a;
  }
}

TEST(Rasterizer, InstructionSetsAgree) {
  const Gaussians g = RandomGaussians(500, 3, 13);
  const Camera camera = TestCamera(64, 64);
  const Rendering best = Render(g, camera);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    const Rendering r = Render(g, camera);
    for (size_t i = 0; i < r.image.color.size(); ++i)
      EXPECT_NEAR(r.image.color[i], best.image.color[i], 1.5 / 255);
    double dot = 0, a2 = 0, b2 = 0;
    for (size_t i = 0; i < r.gradients.values[kPosition].size(); ++i) {
      const double a = r.gradients.values[kPosition][i], b = best.gradients.values[kPosition][i];
      dot += a * b;
      a2 += a * a;
      b2 += b * b;
    }
    EXPECT_GT(dot / std::sqrt(a2 * b2), 0.99999) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Rasterizer, GrazingAndHugeSplatsStayFinite) {
  Gaussians g = RandomGaussians(6, 1, 17);
  const Camera camera = TestCamera(40, 40);
  const float depth_offset = camera.translation[2];
  const float edge = std::nextafter(kNearPlane, 1.0f) - depth_offset;
  const float positions[6][3] = {{0, 0, edge},
                                 {50, 0, edge},
                                 {0, 0, 1e20f},
                                 {1e30f, 0, 1e-3f},
                                 {0, 0, 0},
                                 {-0.05f, 0.02f, -3.0f}};
  for (int i = 0; i < 6; ++i) std::memcpy(g.at(kPosition, i), positions[i], sizeof positions[i]);
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 4)[k] = 46;  // e^46 = 1e20
  const Rendering r = Render(g, camera);
  for (const float v : r.image.color) ASSERT_TRUE(std::isfinite(v));
  for (int a = 0; a < kAttributeCount; ++a)
    for (const float v : r.gradients.values[a]) ASSERT_TRUE(std::isfinite(v)) << a;
}

TEST(Rasterizer, NanGaussiansAreNotDrawn) {
  for (int a = 0; a < kAttributeCount; ++a)
    for (const float poison : {NAN, INFINITY, -INFINITY}) {
      Gaussians g = RandomGaussians(20, 1, 19);
      for (int k = 0; k < g.width(a); ++k) g.values[a][5 * g.width(a) + k] = poison;
      const Rendering r = Render(g, TestCamera(32, 32));
      for (const float v : r.image.color) ASSERT_TRUE(std::isfinite(v)) << a << ' ' << poison;
      for (int b = 0; b < kAttributeCount; ++b)
        for (const float v : r.gradients.values[b]) ASSERT_TRUE(std::isfinite(v)) << a << ' ' << b;
    }
}

// Whatever the sign of the basis function: minus infinity is no black.
TEST(Rasterizer, InfiniteColoursAreNotDrawn) {
  for (const float poison : {INFINITY, -INFINITY})
    for (int k = 0; k < 9; ++k) {
      Gaussians g = RandomGaussians(20, 1, 4);
      for (size_t i = 0; i < g.size(); ++i) g.at(kColorRest, i)[k] = poison;
      const Rendering r = Render(g, TestCamera(40, 40));
      for (const float t : r.image.transmittance) ASSERT_EQ(t, 1) << k << ' ' << poison;
      for (int a = 0; a < kAttributeCount; ++a)
        for (const float v : r.gradients.values[a]) ASSERT_EQ(v, 0) << k << ' ' << poison;
    }
}

TEST(Rasterizer, GroupsThatAreNotDrawnMayKeepTheirGradients) {
  Gaussians g = RandomGaussians(70, 2, 5);
  for (size_t i = 16; i < 48; ++i) g.at(kPosition, i)[2] -= 50;
  g.at(kPosition, 40)[2] += 50;  // one of the third group is drawn
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, TestCamera(64, 64), Settings(2), image, *tape);
  ASSERT_GT(tape->radii()[40], 0);
  const Buffer<float> d_color(image.color.size(), 1.0f);
  Gaussians zeroed = g.ZerosLike(), kept = zeroed;
  Buffer<float> zeroed_screen, kept_screen(2 * 70, 7.0f);
  for (Gaussians* d : {&zeroed, &kept})
    for (auto& values : d->values) std::fill(values.begin(), values.end(), 7.0f);
  rasterizer->Backward(ViewOf(g), image, d_color, *tape, GradientViewOf(zeroed, zeroed_screen));
  WorldGradients some = GradientViewOf(kept, kept_screen);
  some.drawn_groups_only = true;
  rasterizer->Backward(ViewOf(g), image, d_color, *tape, some);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t k = 0; k < zeroed.values[a].size(); ++k) {
      const size_t group = k / g.width(a) / kGaussianGroup;
      if (group == 1) {
        EXPECT_EQ(zeroed.values[a][k], 0);
      }
      EXPECT_EQ(kept.values[a][k], group == 1 ? 7.0f : zeroed.values[a][k]) << a << ' ' << k;
    }
}

TEST(Rasterizer, NothingToDrawGivesTheBackground) {
  for (const size_t n : {size_t(0), size_t(5)}) {
    Gaussians g = RandomGaussians(n, 0, 23);
    for (size_t i = 0; i < n; ++i) g.at(kPosition, i)[2] = -100;  // behind the camera
    for (const int size : {1, 33}) {
      const Rendering r = Render(g, TestCamera(size, size));
      for (size_t i = 0; i < r.image.transmittance.size(); ++i) {
        EXPECT_EQ(r.image.transmittance[i], 1);
        EXPECT_EQ(r.image.color[i], 0.3f);
      }
    }
  }
}

TEST(Rasterizer, ThousandOpaqueSplatsInOnePlace) {
  Gaussians g = RandomGaussians(1000, 0, 29);
  for (size_t i = 0; i < g.size(); ++i) {
    for (int k = 0; k < 3; ++k) g.at(kPosition, i)[k] = 0;
    g.at(kOpacityLogit, i)[0] = 20;
  }
  const Rendering r = Render(g, TestCamera(32, 32));
  for (int a = 0; a < kAttributeCount; ++a)
    for (const float v : r.gradients.values[a]) ASSERT_TRUE(std::isfinite(v));
}

TEST(Rasterizer, SurfaceFrameTurnsTheColour) {
  // Turning the frame by R and the Gaussian with its camera by R must show the same colour.
  Gaussians g = RandomGaussians(1, 3, 31, 0.5f);
  for (int k = 0; k < 3; ++k) g.at(kPosition, 0)[k] = 0;
  const Camera camera = TestCamera(16, 16);
  Buffer<float> frame{0.8f, 0.2f, -0.4f, 0.4f};
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  WorldGaussians view = ViewOf(g);
  view.color_frame = frame.data();
  RenderedImage framed, plain;
  rasterizer->Forward(view, g.basis, camera, Settings(3), framed, *tape);
  // The same direction by hand: a camera on the other side of R^T.
  using namespace math;
  const Mat3<float> r = RotationOf(Normalize(Quat<float>{frame[0], frame[1], frame[2], frame[3]}));
  const auto center = camera.Center();
  const Vec3<float> turned = TransposeTimes(r, Vec3<float>{center[0], center[1], center[2]});
  Vec3<float> color = EvaluateColor<3>(
      Normalize(-turned), BasisConstants(g.basis), g.at(kColorDc, 0), g.at(kColorRest, 0));
  rasterizer->Forward(ViewOf(g), g.basis, camera, Settings(3), plain, *tape);
  const size_t mid = 8 * 16 + 8;
  const float alpha = 1 - framed.transmittance[mid];
  EXPECT_NEAR(framed.color[mid], color.x * alpha + 0.3f * (1 - alpha), 1e-5);
  EXPECT_GT(std::abs(framed.color[mid] - plain.color[mid]), 1e-3);
}

// What another renderer is given draws the same picture here, with its colours as the constant
// function; and blur is added to the footprint.
TEST(ViewSplats, DrawTheSamePicture) {
  Gaussians g = RandomGaussians(60, 3, 43);
  for (int k = 0; k < 3; ++k) g.at(kPosition, 0)[k] = -3.5f * float(k == 2);  // behind the camera
  for (int k = 0; k < 4; ++k) g.at(kRotation, 1)[k] = 0;
  Buffer<float> frame(4 * g.size());
  for (size_t i = 0; i < frame.size(); ++i) frame[i] = std::sin(float(i) + 1);
  WorldGaussians world = ViewOf(g);
  world.color_frame = frame.data();
  const Camera camera = TestCamera(64, 64);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const auto draw = [&](const WorldGaussians& gaussians, int degree) {
    RenderedImage image;
    rasterizer->Forward(gaussians, Basis::kDcsh, camera, Settings(degree), image, *tape);
    return image;
  };
  ViewSplats splats;
  const auto as_gaussians = [&] {
    Gaussians flat;
    flat.Resize(g.size());
    for (size_t i = 0; i < g.size(); ++i) {
      const float opacity = splats.colors[4 * i + 3];
      flat.at(kOpacityLogit, i)[0] = std::log(opacity / (1 - opacity));
      for (int k = 0; k < 4; ++k) flat.at(kRotation, i)[k] = splats.rotations[4 * i + k];
      for (int k = 0; k < 3; ++k) {
        flat.at(kPosition, i)[k] = splats.centers[4 * i + k];
        flat.at(kScaleLog, i)[k] = std::log(splats.scales[4 * i + k]);
        // The rasteriser's constant function.
        flat.at(kColorDc, i)[k] =
            (splats.colors[4 * i + k] - 0.5f) / BasisConstants(Basis::kDcsh)[0];
      }
    }
    return flat;
  };
  const RenderedImage expected = draw(world, 3);

  FillViewSplats(world, Basis::kDcsh, camera, 3, 0, splats);
  // The last two are one behind the camera and one without a rotation.
  const ViewParameters view = ViewOfCamera(camera, Basis::kDcsh, 3);
  using namespace math;
  const Pinhole<float> pinhole = ToPinhole<float>(view);
  float before_it = 0;
  for (size_t i = 0; i + 2 < g.size(); ++i) {
    const float* center = splats.centers.data() + 4 * i;
    const float depth = ToCamera(pinhole, Vec3<float>{center[0], center[1], center[2]}).z;
    EXPECT_GE(depth, before_it);
    before_it = depth;
    EXPECT_GT(splats.colors[4 * i + 3], 0);
  }
  for (size_t i = g.size() - 2; i < g.size(); ++i) EXPECT_EQ(splats.colors[4 * i + 3], 0);
  const Gaussians same = as_gaussians();
  const RenderedImage got = draw(ViewOf(same), 0);
  for (size_t i = 0; i < expected.color.size(); ++i)
    EXPECT_NEAR(got.color[i], expected.color[i], 2e-5);

  // On the optical axis 0.5 px^2 more are 0.5 px^2 of the footprint, whatever the Gaussian's shape.
  for (int k = 0; k < 3; ++k) g.at(kPosition, 2)[k] = -camera.translation[k] * float(k != 2);
  const auto footprint = [&] {
    const Rows row{2, 1};
    const Vec3<float> p = ToCamera(pinhole, LoadVec3<float>(g.at(kPosition, 0), row));
    const Quat<float> q = LoadQuat<float>(g.at(kRotation, 0), row);
    const Vec3<float> scale_log = LoadVec3<float>(g.at(kScaleLog, 0), row);
    return FootprintOf(pinhole, p, q, scale_log, 0.5f, kBlurVariance).covariance;
  };
  FillViewSplats(world, Basis::kDcsh, camera, 3, 0.5f, splats);
  const Sym2<float> before = footprint();
  size_t place = 0;
  while (splats.order.values[place] != 2) ++place;
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 2)[k] = std::log(splats.scales[4 * place + k]);
  const Sym2<float> after = footprint();
  EXPECT_NEAR(after.xx - before.xx, 0.5, 1e-3);
  EXPECT_NEAR(after.yy - before.yy, 0.5, 1e-3);
  EXPECT_NEAR(after.xy, before.xy, 1e-3);
  EXPECT_THROW(FillViewSplats(world, Basis::kDcsh, camera, 4, 0, splats), Error);
  world.antialiased = true;
  EXPECT_THROW(FillViewSplats(world, Basis::kDcsh, camera, 3, 0, splats), Error);
}

TEST(Rasterizer, RefusesAnEmptyImageAndAMissingBand) {
  const Gaussians g = RandomGaussians(1, 0, 37);
  EXPECT_THROW(Render(g, TestCamera(0, 10)), Error);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  EXPECT_THROW(rasterizer->Forward(ViewOf(g), g.basis, TestCamera(8, 8), Settings(2), image, *tape),
               Error);
}

}  // namespace
}  // namespace cosplat
