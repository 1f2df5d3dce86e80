// Gaussians of which each can be told by a tag that is in all of its numbers: density control and
// pruning must keep them together.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/train/density/density.h"

namespace cosplat::test {

constexpr float kSmall = 0.005f, kLarge = 0.05f;  // below and above DensitySettings::split_scale

// Gaussian i carries its tag, i + 1, in every attribute and moment.
inline float TagOf(const Gaussians& g, size_t i) { return g.at(kColorDc, i)[0]; }

struct TaggedGaussians {
  Gaussians g;
  AdamState adam;
  DensityStatistics statistics;
  Gaussians gradients;
  DensitySettings settings;
  DensityControl control;
  Rng rng{1};

  explicit TaggedGaussians(size_t n) {
    g.degree = 1;
    g.Resize(n);
    adam = AdamState(g);
    adam.step = 5;
    adam.updated.assign(adam.updated.size(), 5);
    for (size_t i = 0; i < n; ++i) {
      const float tag = float(i + 1);
      for (int k = 0; k < 3; ++k) {
        g.at(kPosition, i)[k] = 10 * tag + float(k);
        g.at(kColorDc, i)[k] = tag;
      }
      for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = tag + 0.1f * float(k);
      g.at(kRotation, i)[0] = tag;
      g.at(kRotation, i)[1] = 1;
      g.at(kOpacityLogit, i)[0] = 0.001f * tag;
      SetScale(i, kSmall);
      for (int a = 0; a < kAttributeCount; ++a)
        for (int k = 0; k < g.width(a); ++k) {
          adam.m.at(Attribute(a), i)[k] = tag;
          adam.v.at(Attribute(a), i)[k] = 2 * tag;
        }
    }
    statistics.Reset(n);
    for (size_t i = 0; i < n; ++i) See(i, 0, 1);
  }
  void SetScale(size_t i, float scale) {
    for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = std::log(scale) - 0.1f * float(k);
  }
  // Seen in four steps with these means.
  void See(size_t i, float gradient, float plasticity) {
    statistics.visible[i] = 4;
    statistics.screen_gradient[i] = 4 * gradient;
    statistics.plasticity[i] = 4 * plasticity;
  }
  Population With(Placement& placement, Pruner* pruner = nullptr) {
    return {placement, g, adam, statistics, gradients, HostStream(), nullptr, pruner};
  }
  // Density control, after which the statistics begin anew.
  DensityReport Control(Placement& placement, bool oversized = false) {
    const DensityReport report = control.Control(settings, oversized, With(placement), rng);
    statistics.Reset(g.size());
    return report;
  }
  DensityReport Control() {
    Placement placement;
    return Control(placement);
  }
  std::vector<int> Tags() const {
    std::vector<int> tags;
    for (size_t i = 0; i < g.size(); ++i) tags.push_back(int(TagOf(g, i)));
    return tags;
  }
};
using Tags = std::vector<int>;

// Follows the tags by itself, as an avatar's binding follows its triangles.
class Recorder : public Placement {
 public:
  explicit Recorder(const TaggedGaussians& p) {
    for (const int tag : p.Tags()) tags.push_back(tag);
  }
  void Gather(View<const uint32_t> source, Stream&) override {
    std::vector<int> gathered;
    for (const uint32_t i : source) {
      ASSERT_LT(i, tags.size());
      gathered.push_back(tags[i]);
    }
    tags = gathered;
  }
  void Move(View<const float> offsets, size_t first, Gaussians& g, Stream& stream) override {
    ASSERT_EQ(first + offsets.count / 3, tags.size());
    for (size_t i = first; i < tags.size(); ++i) {
      EXPECT_EQ(int(TagOf(g, i)), tags[i]);  // gathered before it is moved
      moved.push_back(tags[i]);
    }
    Placement::Move(offsets, first, g, stream);
  }
  std::vector<int32_t> Groups(Stream&) override {
    std::vector<int32_t> groups;
    for (const int tag : tags) groups.push_back(groups_of_tag.empty() ? 0 : groups_of_tag[tag]);
    return groups;
  }
  std::vector<int> tags, moved, groups_of_tag;
};

// All that belongs to one Gaussian has its tag; new ones have no moments.
inline void ExpectAligned(const TaggedGaussians& p) {
  for (size_t i = 0; i < p.g.size(); ++i) {
    const float tag = TagOf(p.g, i);
    EXPECT_EQ(p.g.at(kRotation, i)[0], tag);
    EXPECT_EQ(p.g.at(kOpacityLogit, i)[0], 0.001f * tag);
    for (int k = 0; k < p.g.width(kColorRest); ++k)
      EXPECT_EQ(p.g.at(kColorRest, i)[k], tag + 0.1f * float(k));
    EXPECT_NEAR(p.g.at(kPosition, i)[1], 10 * tag + 1, 1);  // children: 5 deviations away at most
    const bool is_new = p.adam.m.at(kPosition, i)[0] == 0;
    for (int a = 0; a < kAttributeCount; ++a)
      for (int k = 0; k < p.g.width(a); ++k) {
        EXPECT_EQ(p.adam.m.at(Attribute(a), i)[k], is_new ? 0 : tag);
        EXPECT_EQ(p.adam.v.at(Attribute(a), i)[k], is_new ? 0 : 2 * tag);
      }
  }
  for (const Buffer<float>* b :
       {&p.statistics.screen_gradient, &p.statistics.plasticity, &p.statistics.visible})
    EXPECT_EQ(*b, Buffer<float>(p.g.size(), 0.0f));
}

}  // namespace cosplat::test
