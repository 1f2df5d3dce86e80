#include "splat/train/describe_state.h"

#include <algorithm>

namespace cosplat {
namespace {

constexpr std::array<const char*, kAttributeCount> kNames{
    "position", "rotation", "scale_log", "opacity_logit", "color_dc", "color_rest", "correction"};

// Gaussians at most: what indices of 32 bits can count.
constexpr uint64_t kMaxCount = 0x7fffffff;

// In parts, so that the rank that writes them need not have all of them at once.
void DescribeMoments(
    StateArchive& a, const std::string& name, const Gaussians& of, Shards& shards, Gaussians& m) {
  if (a.reads()) {
    m.degree = of.degree;
    m.basis = of.basis;
    m.corrections = of.corrections;
    m.Resize(shards.share().CountOf(of.size()));
  }
  for (int k = 0; k < kAttributeCount; ++k) {
    const size_t width = size_t(m.width(k));
    for (size_t begin = 0; begin < of.size(); begin += kRowsPerExchange) {
      const size_t end = std::min(begin + kRowsPerExchange, of.size());
      Buffer<float> rows;
      if (!a.reads()) rows = shards.Assembled(m.values[k], width, begin, end);
      if (a.reads() || shards.share().rank == 0)
        a.Array(name + "." + kNames[k] + "." + std::to_string(begin), rows, (end - begin) * width);
      if (a.reads()) shards.TakeOwn(rows, width, begin, end, m.values[k]);
    }
  }
}

void Describe(StateArchive& a, const Gaussians& of, Shards& shards, AdamState& adam) {
  DescribeMoments(a, "adam.m", of, shards, adam.m);
  DescribeMoments(a, "adam.v", of, shards, adam.v);
  a.Value("adam.step", adam.step);
  a.Array("adam.updated", adam.updated, AdamGroupCount(of.size()));
  a.Array("adam.ignored", adam.ignored, 1);
  for (const uint32_t step : adam.updated)
    a.Require(step <= adam.step, "adam.updated", "is ahead of the run");
}

}  // namespace

void Describe(StateArchive& a, const std::string& name, size_t count, Gaussians& g) {
  for (int k = 0; k < kAttributeCount; ++k)
    a.Array(name + "." + kNames[k], g.values[k], count * size_t(g.width(k)));
  a.ArrayUpTo(name + ".degrees", g.degrees, count);
  a.Require(g.degrees.empty() || g.degrees.size() == count, name + ".degrees", "are not all there");
  a.ArrayUpTo(name + ".smoothing", g.smoothing, count);
  a.Require(
      g.smoothing.empty() || g.smoothing.size() == count, name + ".smoothing", "are not all there");
  for (const uint8_t degree : g.degrees)
    a.Require(degree <= g.degree, name + ".degrees", "exceed the run's degree");
}

void Describe(StateArchive& a, size_t frames, Shards& shards, TrainingState& s) {
  a.Value("iteration", s.iteration);
  a.Require(s.iteration >= 0, "iteration", "is negative");
  a.Value("rng", s.rng.state);
  a.ArrayUpTo("frames_left", s.frames_left, frames);
  for (const uint32_t frame : s.frames_left)
    a.Require(frame < frames, "frames_left", "names a frame that is not there");
  uint64_t count = s.gaussians.size();
  a.Value("count", count);
  a.Require(count > 0 && count <= kMaxCount, "count", "is " + std::to_string(count));
  Describe(a, "gaussians", count, s.gaussians);
  Describe(a, s.gaussians, shards, s.adam);
  a.Array("statistics.screen_gradient", s.statistics.screen_gradient, count);
  a.Array("statistics.plasticity", s.statistics.plasticity, count);
  a.Array("statistics.visible", s.statistics.visible, count);
  // Of as many frames as the run's settings have it.
  Describe(a, s.exposures.value.size() / math::kExposureNumbers, s.exposures);
}

void Describe(StateArchive& a, const std::string& name, size_t count, LearnedMask& mask) {
  a.Array(name + ".value", mask.value, count);
  a.Array(name + ".m", mask.m, count);
  a.Array(name + ".v", mask.v, count);
  a.Value(name + ".step", mask.step);
}

void Describe(StateArchive& a, size_t frames, ExposureState& exposures) {
  const size_t numbers = frames * math::kExposureNumbers;
  a.Array("exposures.value", exposures.value, numbers);
  a.Array("exposures.m", exposures.m, numbers);
  a.Array("exposures.v", exposures.v, numbers);
  a.Array("exposures.updates", exposures.updates, numbers);
}

}  // namespace cosplat
