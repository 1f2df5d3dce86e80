#include "splat/train/serialize_state.h"

#include <algorithm>
#include <functional>

namespace cosplat {
namespace {

// Gaussians at most: what indices of 32 bits can count.
constexpr uint64_t kMaxCount = 0x7fffffff;

// An array that ranks divide: `width` numbers for every `rows_per_entry` Gaussians. In parts, so
// that the rank that writes it need not have all of it. check: of what is read, which all ranks
// call with the same.
template <class T>
struct Divided {
  StateArchive& a;
  Shards& shards;
  std::string name;
  size_t count;  // Gaussians of all
  size_t width = 1;
  size_t rows_per_entry = 1;
  bool counted = true;  // another array was read, and has so many
  std::function<void(const Buffer<T>&)> check = [](const Buffer<T>&) {};

  size_t Entries(size_t rows) const { return (rows + rows_per_entry - 1) / rows_per_entry; }
  size_t OwnNumbers(size_t rows) const { return Entries(shards.share().CountOf(rows)) * width; }
  void Serialize(Buffer<T>& own) const {
    if (a.reads()) own = {};
    if (a.reads() && counted) own.reserve(OwnNumbers(count));
    for (size_t begin = 0; begin < count; begin += kRowsPerExchange) {
      const Stretch rows{begin, std::min(begin + kRowsPerExchange, count), width, rows_per_entry};
      Buffer<T> part;
      if (!a.reads()) part = shards.Assembled(own, rows, ForWhom::kFirstRank);
      if (a.reads() || shards.share().rank == 0)
        a.Array(name + "." + std::to_string(begin), part, Entries(rows.end - begin) * width);
      if (!a.reads()) continue;
      check(part);
      // As far as it was read: no more than what is in the file.
      own.resize(OwnNumbers(rows.end));
      shards.TakeOwn(part, rows, own);
    }
    if (a.reads() && !counted) own = Buffer<T>(own.begin(), own.end());  // without room for more
  }
};

// The same where it may be missing.
template <class T>
void DescribeOptional(const Divided<T>& array, Buffer<T>& own) {
  uint8_t has = 0;
  if (!array.a.reads()) has = array.shards.AnyHas(own) ? 1 : 0;
  array.a.Value(array.name, has);
  array.a.Require(has <= 1, array.name, "is neither there nor missing");
  if (has != 0)
    array.Serialize(own);
  else
    own.clear();
}

// counted: as above.
void DescribeDivided(StateArchive& a,
                     const std::string& name,
                     size_t count,
                     bool counted,
                     Shards& shards,
                     Gaussians& own) {
  for (int k = 0; k < kAttributeCount; ++k) {
    const bool is_known = counted || k > 0;
    const Divided<float> array{
        a, shards, name + "." + kAttributeNames[k], count, size_t(own.width(k)), 1, is_known};
    array.Serialize(own.values[k]);
  }
}

// That no Gaussian has a higher degree than all may have.
std::function<void(const Buffer<uint8_t>&)> CheckDegrees(const StateArchive& a,
                                                         const std::string& name,
                                                         int highest) {
  return [&a, name, highest](const Buffer<uint8_t>& degrees) {
    for (const uint8_t degree : degrees)
      a.Require(degree <= highest, name, "exceed the run's degree");
  };
}

void Serialize(
    StateArchive& a, const Gaussians& of, size_t count, Shards& shards, AdamState& adam) {
  for (Gaussians* moments : {&adam.m, &adam.v}) {
    if (a.reads()) *moments = of.ZerosLike(0);
    DescribeDivided(a, moments == &adam.m ? "adam.m" : "adam.v", count, true, shards, *moments);
  }
  a.Value("adam.step", adam.step);
  const auto check = [&](const Buffer<uint32_t>& updated) {
    for (const uint32_t step : updated)
      a.Require(step <= adam.step, "adam.updated", "is ahead of the run");
  };
  const Divided<uint32_t> updated{a, shards, "adam.updated", count, 1, kGaussianGroup, true, check};
  updated.Serialize(adam.updated);
  // The sum over all ranks; the first goes on counting.
  uint64_t ignored = a.reads() ? 0 : shards.SumOver(adam.ignored[0]);
  a.Value("adam.ignored", ignored);
  if (a.reads()) adam.ignored.assign(1, shards.share().rank == 0 ? uint32_t(ignored) : 0);
}

}  // namespace

void Serialize(StateArchive& a, const std::string& name, size_t count, Gaussians& g) {
  for (int k = 0; k < kAttributeCount; ++k)
    a.Array(name + "." + kAttributeNames[k], g.values[k], count * size_t(g.width(k)));
  a.ArrayUpTo(name + ".degrees", g.degrees, count);
  a.Require(g.degrees.empty() || g.degrees.size() == count, name + ".degrees", "are not all there");
  a.ArrayUpTo(name + ".smoothing", g.smoothing, count);
  a.Require(
      g.smoothing.empty() || g.smoothing.size() == count, name + ".smoothing", "are not all there");
  CheckDegrees(a, name + ".degrees", g.degree)(g.degrees);
}

void Serialize(
    StateArchive& a, size_t frames, Shards& shards, uint64_t& gaussians, TrainingState& s) {
  a.Value("iteration", s.iteration);
  a.Require(s.iteration >= 0, "iteration", "is negative");
  a.Value("rng", s.rng.state);
  a.ArrayUpTo("frames_left", s.frames_left, frames);
  for (const uint32_t frame : s.frames_left)
    a.Require(frame < frames, "frames_left", "names a frame that is not there");
  a.Value("count", gaussians);
  a.Require(gaussians > 0 && gaussians <= kMaxCount, "count", "is " + std::to_string(gaussians));
  const auto count = size_t(gaussians);
  DescribeDivided(a, "gaussians", count, false, shards, s.gaussians);
  const auto check = CheckDegrees(a, "gaussians.degrees", s.gaussians.degree);
  DescribeOptional<uint8_t>({a, shards, "gaussians.degrees", count, 1, 1, true, check},
                            s.gaussians.degrees);
  DescribeOptional<float>({a, shards, "gaussians.smoothing", count}, s.gaussians.smoothing);
  Serialize(a, s.gaussians, count, shards, s.adam);
  DensityStatistics::ForEachArray(
      [&](const std::string& name, size_t width, Buffer<float>& own) {
        const Divided<float> array{a, shards, "statistics." + name, count, width};
        array.Serialize(own);
      },
      s.statistics);
  // As many frames as the run's settings say.
  Serialize(a, s.exposures.value.size() / math::kExposureNumbers, s.exposures);
}

void Serialize(StateArchive& a, size_t frames, ExposureState& exposures) {
  const size_t numbers = frames * math::kExposureNumbers;
  ExposureState::ForEachArray(
      [&](const std::string& name, size_t, auto& array) {
        a.Array("exposures." + name, array, numbers);
      },
      exposures);
}

}  // namespace cosplat
