// flame/fit/: the part of the track's fit that compares outlines.
#include "flame/fit/silhouette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splat/media/image_io.h"
#include "tests/flame/filmed_head.h"

namespace cosplat {
namespace {

using internal::FieldCost;
using internal::FrameFields;
using internal::FrameView;
using internal::OutlinePoint;
using internal::RimDistance;
using internal::SampleAt;
using internal::Silhouette;
using test::FilmedHead;

// A disc's matte.
Image8 Disc(int size, double radius) {
  Image8 image(size, size, 4);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      image.at(x, y, 3) = std::hypot(x + 0.5 - size / 2.0, y + 0.5 - size / 2.0) < radius ? 255 : 0;
  return image;
}

TEST(RimDistance, IsThatFromADisc) {
  const Image8 disc = Disc(200, 60);
  for (double scale : {1.0, 0.5}) {
    const auto rim = RimDistance(disc, {0, 0, 200, 200}, scale);
    ASSERT_TRUE(rim);
    for (double angle = 0; angle < 6; angle += 0.3)
      for (double distance : {-40.0, -10.0, -1.0, 0.0, 2.0, 20.0}) {
        const double r = 60 + distance;
        EXPECT_NEAR(SampleAt(*rim, 100 + r * std::cos(angle), 100 + r * std::sin(angle)).value,
                    distance,
                    1.2);
      }
  }
}

TEST(RimDistance, IsNothingWithoutARim) {
  EXPECT_FALSE(RimDistance(Image8(20, 20, 4, 255), {0, 0, 20, 20}, 1));
  EXPECT_FALSE(RimDistance(Image8(20, 20, 4, 0), {0, 0, 20, 20}, 1));
}

struct OutlinedHead : FilmedHead {
  std::vector<std::optional<FrameView>> views;
  std::vector<FrameFields> fields;

  explicit OutlinedHead(int frames, FlameModel filmed = MakeProceduralHead())
      : FilmedHead(0, 0, 0) {
    script = MakeScript(frames);
    const FlamePoser<float> filmed_poser(filmed, {});
    for (size_t f = 0; f < script.size(); ++f) {
      std::vector<float> vertices;
      filmed_poser.Forward(FlamePoser<float>::ParametersOf(script[f].params), vertices);
      images.push_back(RenderProceduralHead(head, vertices, script[f].params, script[f].camera));
      views.push_back(View(f));
    }
    fields = internal::ReadFields(views, [&](size_t f) { return images[f]; });
  }
  std::vector<OutlinePoint> Outline(const FlameModel& model, size_t f) const {
    const Silhouette silhouette(model, 0, model.expression_count);
    return silhouette.Outline(nullptr, LogFocal(), Numbers(f).data(), *fields[f].rim, *views[f]);
  }
};

TEST(Silhouette, OfTheTruthLiesOnTheRim) {
  const OutlinedHead filmed(20);
  for (size_t f : {size_t(0), size_t(19)}) {
    const std::vector<OutlinePoint> outline = filmed.Outline(filmed.head.model, f);
    size_t near = 0, compared = 0;
    for (const OutlinePoint& point : outline) {
      if (point.more_in_matte) continue;
      ++compared;
      near += std::abs(point.distance) < 1;
    }
    EXPECT_GT(compared, 15u);
    EXPECT_GT(near, compared * 9 / 10);
  }
}

TEST(Silhouette, PullsAHeadThatIsAside) {
  const OutlinedHead filmed(1);
  const int expressions = filmed.head.model.expression_count;
  const Silhouette silhouette(filmed.head.model, 0, expressions);
  const double log_focal = filmed.LogFocal();
  const auto loss = [&](double aside, double* slope) {
    std::vector<double> numbers = filmed.Numbers(0);
    numbers[kFitTranslation] += aside;
    const std::unique_ptr<FieldCost> cost = silhouette.Cost(
        nullptr, log_focal, numbers.data(), *filmed.fields[0].rim, *filmed.views[0]);
    const double* const parameters[] = {nullptr, &log_focal, numbers.data()};
    const size_t rows = size_t(cost->num_residuals());
    std::vector<double> residuals(rows), by_frame(rows * numbers.size());
    double* jacobians[] = {nullptr, nullptr, by_frame.data()};
    EXPECT_TRUE(cost->Evaluate(parameters, residuals.data(), jacobians));
    double sum = 0;
    *slope = 0;
    for (size_t r = 0; r < rows; ++r) {
      sum += residuals[r] * residuals[r] / double(rows);
      *slope += residuals[r] * by_frame[r * numbers.size() + kFitTranslation];
    }
    return sum;
  };
  double slope;
  const double at_truth = loss(0, &slope);
  EXPECT_GT(loss(0.006, &slope), 4 * at_truth);
  EXPECT_GT(slope, 0);
  EXPECT_GT(loss(-0.006, &slope), 4 * at_truth);
  EXPECT_LT(slope, 0);
}

// Hair of a centimetre above and behind the eyes is found where the outline shows it.
TEST(HairOffset, IsWhatTheMattesShow) {
  FlameModel with_hair = MakeProceduralHead();
  const FlameModel plain = with_hair;
  const Silhouette silhouette(plain, 0, 0);
  for (size_t v = 0; v < size_t(plain.vertex_count); ++v) {
    float* const p = &with_hair.template_vertices[3 * v];
    const double grown = std::clamp(-double(p[2]) / 0.03, 0.0, 1.0);  // behind the face
    if (!silhouette.may_have_hair()[v] || grown == 0) continue;
    const double length = std::hypot(p[0], p[1], p[2]);
    for (size_t k = 0; k < 3; ++k) p[k] *= float(1 + 0.01 * grown / length);
  }
  const OutlinedHead filmed(60, with_hair);
  std::vector<std::vector<double>> frames;
  std::vector<size_t> picked;
  for (size_t f = 0; f < filmed.script.size(); ++f) {
    frames.push_back(filmed.Numbers(f));
    picked.push_back(f);
  }
  const std::vector<float> offset = internal::FitHairOffset(
      plain, {}, filmed.LogFocal(), frames, picked, filmed.views, filmed.fields);
  ASSERT_EQ(offset.size(), plain.template_vertices.size());
  FlameModel found = plain;
  for (size_t i = 0; i < offset.size(); ++i) found.template_vertices[i] += offset[i];
  const auto mean_gap = [&](const FlameModel& model) {  // px
    double sum = 0, count = 0;
    for (size_t f = 0; f < filmed.script.size(); f += 10)
      for (const OutlinePoint& point : filmed.Outline(model, f)) {
        const float* const p = &plain.template_vertices[3 * size_t(point.vertices[0])];
        if (!silhouette.may_have_hair()[size_t(point.vertices[0])] || p[2] > -0.03f) continue;
        sum += std::abs(point.distance);
        ++count;
      }
    return sum / count;
  };
  const double before = mean_gap(plain), after = mean_gap(found);
  std::printf("%.2f px without hair, %.2f px with it\n", before, after);
  EXPECT_GT(before, 4);
  EXPECT_LT(after, 0.25 * before);
}

TEST(HairOffset, IsNothingWithoutMattes) {
  const FilmedHead filmed(3, 0, 0);
  const std::vector<std::optional<FrameView>> views(3, filmed.View(0));
  const std::vector<FrameFields> fields(3);
  EXPECT_TRUE(internal::FitHairOffset(filmed.head.model,
                                      {},
                                      filmed.LogFocal(),
                                      {filmed.Numbers(0), filmed.Numbers(1), filmed.Numbers(2)},
                                      {0, 1, 2},
                                      views,
                                      fields)
                  .empty());
}

}  // namespace
}  // namespace cosplat
