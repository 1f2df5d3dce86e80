// flame/fit/: the part of the track's fit that compares images.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "flame/fit/face_texture.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/fit/frame_field.h"
#include "flame/pose.h"
#include "splat/base/rng.h"
#include "tests/flame/filmed_head.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using internal::BandPass;
using internal::FaceTexture;
using internal::FieldAt;
using internal::FieldCost;
using internal::FrameField;
using internal::FrameView;
using internal::SampleAt;
using test::ExpectError;
using test::FilmedHead;

constexpr std::array<double, 4> kWhole{0, 0, 1e9, 1e9};

// Waves some 15 pixels long on a slope.
Image8 Waves(int width, int height, int channels) {
  Image8 image(width, height, channels, 255);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = uint8_t(100 + x / 2 + 30 * std::sin(0.4 * x + 0.1 * y));
  return image;
}

TEST(BandPass, LeavesTextureAndNoSlope) {
  const FrameField waves = BandPass(Waves(120, 90, 3), kWhole, 1);
  const FrameField flat = BandPass(Image8(120, 90, 3, 200), kWhole, 1);
  double max = 0, sum = 0;
  for (int x = 30; x < 90; ++x) {
    max = std::max(max, SampleAt(waves, x, 45).value);
    sum += SampleAt(waves, x, 45).value / 60;
    EXPECT_NEAR(SampleAt(flat, x, 45).value, 0, 1e-3);
  }
  EXPECT_GT(max, 15);
  EXPECT_NEAR(sum, 0, 2);
}

TEST(BandPass, PlacesAreThoseOfTheFrame) {
  const Image8 frame = Waves(200, 160, 3);
  const FrameField whole = BandPass(frame, kWhole, 1);
  const FrameField part = BandPass(frame, {50, 40, 150, 120}, 1);
  const FrameField half = BandPass(frame, kWhole, 0.5);
  EXPECT_EQ(part.image.width, 100);
  EXPECT_EQ(half.image.height, 80);
  EXPECT_NEAR(SampleAt(part, 100.3, 80.7).value, SampleAt(whole, 100.3, 80.7).value, 1e-3);
  // Zero crossings are where they were.
  for (double x = 70; x < 130; x += 0.5) {
    const double full = SampleAt(whole, x, 80).value;
    if (std::abs(full) > 12) {
      EXPECT_GT(full * SampleAt(half, x, 80).value, 0) << x;
    }
  }
  EXPECT_FALSE(SampleAt(part, 49, 80).inside);
  EXPECT_FALSE(SampleAt(part, NAN, 80).inside);
}

TEST(BandPass, DerivativeIsThatOfDifferences) {
  const FrameField image = BandPass(Waves(120, 90, 3), kWhole, 0.7);
  constexpr double kStep = 1e-4, x = 61.23, y = 40.31;
  const FieldAt at = SampleAt(image, x, y);
  ASSERT_TRUE(at.inside);
  EXPECT_NEAR(
      at.d_x,
      (SampleAt(image, x + kStep, y).value - SampleAt(image, x - kStep, y).value) / (2 * kStep),
      1e-6);
  EXPECT_NEAR(
      at.d_y,
      (SampleAt(image, x, y + kStep).value - SampleAt(image, x, y - kStep).value) / (2 * kStep),
      1e-6);
}

// What is behind a head does not change what its rim looks like.
TEST(BandPass, NothingOutsideTheMatteCounts) {
  Image8 white = Waves(120, 90, 4), black = white;
  for (int y = 0; y < 90; ++y)
    for (int x = 60; x < 120; ++x)
      for (int c = 0; c < 4; ++c) {
        white.at(x, y, c) = c < 3 ? 255 : 0;
        black.at(x, y, c) = 0;
      }
  const FrameField before_white = BandPass(white, kWhole, 1);
  const FrameField before_black = BandPass(black, kWhole, 1);
  for (int x = 20; x < 60; ++x)
    EXPECT_EQ(SampleAt(before_white, x, 45).value, SampleAt(before_black, x, 45).value);
}

TEST(FitLandmarks, ImagesMakeItMoreExact) {
  const FilmedHead filmed(24, 0.5, 1);
  const LandmarkFit by_landmarks = filmed.Fit(false), by_images = filmed.Fit(true);
  const double before = filmed.Error(by_landmarks), after = filmed.Error(by_images);
  std::printf("%.3f px by landmarks, %.3f px by images\n", before, after);
  EXPECT_LT(after, 0.8 * before);
  EXPECT_TRUE(by_landmarks.brightness_spread.empty());
  const std::vector<double>& spread = by_images.brightness_spread;
  ASSERT_GE(spread.size(), 2u);
  for (size_t round = 1; round < spread.size(); ++round)
    EXPECT_LT(spread[round], spread[round - 1]);
}

TEST(FitLandmarks, SameBitsForAnyNumberOfThreadsWithImages) {
  const FilmedHead filmed(12, 0.5, 0.5);
  const auto fit = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return filmed.Fit(true);
  };
  const LandmarkFit one = fit(1), three = fit(3);
  EXPECT_EQ(one.brightness_spread, three.brightness_spread);
  for (size_t f = 0; f < one.frames.size(); ++f) {
    EXPECT_EQ(one.frames[f]->params.expression, three.frames[f]->params.expression);
    EXPECT_EQ(one.frames[f]->params.pose, three.frames[f]->params.pose);
  }
}

// Images that say nothing leave the landmarks' fit.
TEST(FitLandmarks, BlankImagesDoNotHarm) {
  FilmedHead filmed(6, 0.5, 0.5);
  for (Image8& image : filmed.images) image = Image8(FilmedHead::kSize, FilmedHead::kSize, 3, 128);
  EXPECT_LT(filmed.Error(filmed.Fit(true)), 1.05 * filmed.Error(filmed.Fit(false)));
}

// A track that somebody else made, with noise, from cameras that move.
TEST(RefineTrack, ComesNearerToTheTruth) {
  const FilmedHead filmed(24, 0, 0);
  TrackedVideo video;
  video.source = "noisy";
  Rng rng{3};
  for (size_t f = 0; f < filmed.script.size(); ++f) {
    TrackedFrame frame;
    frame.name = std::to_string(f);
    frame.timestep = int(f);
    frame.camera = filmed.script[f].camera;
    frame.params = filmed.script[f].params;
    for (size_t i = 0; i < 3; ++i) {
      frame.params.translation[i] += float(1.5e-3 * rng.Normal());
      frame.params.pose[1][i] += float(0.02 * rng.Normal());
    }
    (f % 6 == 5 ? video.test : video.train).push_back(frame);
  }
  // Mean distance of the head's vertices from where they are.
  const auto error = [&] {
    double sum = 0, count = 0;
    std::vector<float> found, truth;
    for (const auto* set : {&video.train, &video.test})
      for (const TrackedFrame& frame : *set) {
        filmed.poser.Forward(FlamePoser<float>::ParametersOf(frame.params), found);
        filmed.poser.Forward(
            FlamePoser<float>::ParametersOf(filmed.script[size_t(frame.timestep)].params), truth);
        for (const EmbeddedLandmark& point : filmed.embedding) {
          const size_t v = 3 * size_t(point.vertices[0]);
          const auto a = FilmedHead::Project(frame.camera, &found[v]);
          const auto b = FilmedHead::Project(frame.camera, &truth[v]);
          sum += std::hypot(a[0] - b[0], a[1] - b[1]);
          ++count;
        }
      }
    return sum / count;
  };
  const double before = error();
  const std::vector<double> spread =
      RefineTrack(filmed.head.model, video, [&](const TrackedFrame& frame) {
        return filmed.images[size_t(frame.timestep)];
      });
  const double after = error();
  std::printf("%.3f px before, %.3f px after\n", before, after);
  EXPECT_LT(after, 0.6 * before);
  EXPECT_LT(spread.back(), spread.front());
  video.test[0].camera.fx *= 2;
  ExpectError([&] { RefineTrack(filmed.head.model, video, {}); }, {"noisy", "cameras", "'5'"});
  video.test[0].timestep = 0;
  ExpectError([&] { RefineTrack(filmed.head.model, video, {}); },
              {"noisy", "frames", "'5'", "'0'"});
}

TEST(FieldCost, DerivativeIsThatOfDifferences) {
  const FilmedHead filmed(12, 0, 0);
  const LandmarkFit fit = filmed.Fit(false);
  std::vector<std::optional<FrameView>> views(filmed.faces.size());
  for (std::optional<FrameView>& view : views) {
    view.emplace();
    view->lens = {FilmedHead::kSize / 2.0, FilmedHead::kSize / 2.0};
    view->box = kWhole;
    view->face_size = 125;
  }
  const auto fields = internal::ReadFields(views, [&](size_t f) { return filmed.images[f]; });
  FaceTexture texture(filmed.head.model, 0, filmed.head.model.expression_count, views, fields);
  std::vector<std::vector<double>> frames;
  for (const auto& frame : fit.frames) {
    std::vector<double> numbers(frame->params.translation.begin(), frame->params.translation.end());
    for (const auto& joint : frame->params.pose)
      numbers.insert(numbers.end(), joint.begin(), joint.end());
    numbers.insert(numbers.end(), frame->params.expression.begin(), frame->params.expression.end());
    frames.push_back(numbers);
  }
  double log_focal = std::log(fit.camera.fx);
  texture.Measure({}, log_focal, frames);
  const std::unique_ptr<FieldCost> made = texture.Cost(1);
  ASSERT_TRUE(made);
  const FieldCost& cost = *made;
  ASSERT_GT(cost.num_residuals(), 300);
  const size_t rows = size_t(cost.num_residuals()), size = frames[1].size();
  std::vector<double>& frame = frames[1];
  const auto residuals = [&] {
    std::vector<double> out(rows);
    const double* const parameters[] = {nullptr, &log_focal, frame.data()};
    EXPECT_TRUE(cost.Evaluate(parameters, out.data(), nullptr));
    return out;
  };
  std::vector<double> values(rows), by_focal(rows), by_frame(rows * size);
  const double* const parameters[] = {nullptr, &log_focal, frame.data()};
  double* jacobians[] = {nullptr, by_focal.data(), by_frame.data()};
  ASSERT_TRUE(cost.Evaluate(parameters, values.data(), jacobians));
  // Bilinear images have kinks; most rows stay within a pixel.
  const auto expect_most_near = [&](double& number, const auto& derivative, double step) {
    const double kept = number;
    number = kept + step;
    const std::vector<double> more = residuals();
    number = kept - step;
    const std::vector<double> less = residuals();
    number = kept;
    size_t near = 0;
    for (size_t r = 0; r < rows; ++r) {
      const double difference = (more[r] - less[r]) / (2 * step);
      near += std::abs(derivative(r) - difference) < 1e-4 + 1e-3 * std::abs(difference);
    }
    EXPECT_GT(near, rows * 95 / 100);
  };
  expect_most_near(
      log_focal, [&](size_t r) { return by_focal[r]; }, 1e-6);
  for (size_t k : {size_t(0), size_t(2), size_t(kFitPose + 1), size_t(kFitPose + 6), size - 1})
    expect_most_near(
        frame[k], [&](size_t r) { return by_frame[r * size + k]; }, 1e-6);
}

}  // namespace
}  // namespace cosplat
