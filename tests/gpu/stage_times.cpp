#include "tests/gpu/stage_times.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cosplat::test {
namespace {

using cuda::CudaRasterizer;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Counted from what the kernels read and write once; gathers of 4 bytes as 4.
std::array<double, kStageNames.size()> BytesOf(DeviceStep& step, bool records) {
  const double n = double(step.gaussians.size()), i = double(step.counts.instances);
  const double visible = double(step.counts.visible), capacity = double(step.tape.capacity());
  const double pixels = double(step.image.width) * step.image.height;
  double numbers = 0;  // of a Gaussian
  for (int a = 0; a < kAttributeCount; ++a) numbers += step.gaussians.width(a);
  constexpr double kSplat = sizeof(ProjectedSplat), kGradient = sizeof(SplatGradient);
  constexpr double kPair = 16;  // key and value, read and written, per pass over 8 bits
  const double tile_passes = std::ceil(std::bit_width(step.tape.lists.tiles()) / 8.0);
  const double lists = i * 12 + capacity * (kPair * tile_passes + 12);
  const double checkpoints = 128 * i;
  return {n * (4 * numbers + kSplat + 4 + 8),
          n * 4 * kPair + visible * 2 * kSplat + lists,
          i * (4 + kSplat) + checkpoints + 16 * pixels,
          pixels * (3 * 5 + 36 + 36 + 3 * 5 + 12),
          i * (4 + kSplat + kGradient) + checkpoints + 24 * pixels + (records ? i * kGradient : 0) +
              n * kGradient,
          n * 4 + visible * (8 * numbers + kSplat + kGradient),
          visible * 28 * numbers};
}

}  // namespace

StepTimes TimeSteps(DeviceStep& step, int steps) {
  cuda::TimedEvent before_loss, after_loss, before_adam, after_adam, begin, end;
  std::array<std::vector<double>, kStageNames.size()> ms;
  std::vector<double> whole;
  for (int s = 0; s < 2 * steps; ++s) {
    begin.Record(step.stream());
    step.Draw();
    before_loss.Record(step.stream());
    step.Compare();
    after_loss.Record(step.stream());
    step.Backward();
    before_adam.Record(step.stream());
    step.Update();
    after_adam.Record(step.stream());
    end.Record(step.stream());
    const bool sufficed = step.Settle();
    if (s < steps || !sufficed) continue;
    const CudaRasterizer& r = step.rasterizer;
    ms[0].push_back(r.MillisecondsBetween(CudaRasterizer::kStart, CudaRasterizer::kProjected));
    ms[1].push_back(r.MillisecondsBetween(CudaRasterizer::kProjected, CudaRasterizer::kSorted));
    ms[2].push_back(r.MillisecondsBetween(CudaRasterizer::kSorted, CudaRasterizer::kBlended));
    ms[3].push_back(after_loss.MillisecondsSince(before_loss));
    ms[4].push_back(
        r.MillisecondsBetween(CudaRasterizer::kBackStart, CudaRasterizer::kBlendedBack));
    ms[5].push_back(r.MillisecondsBetween(CudaRasterizer::kBlendedBack, CudaRasterizer::kBack));
    ms[6].push_back(after_adam.MillisecondsSince(before_adam));
    whole.push_back(end.MillisecondsSince(begin));
  }
  StepTimes times;
  const auto bytes = BytesOf(step, !step.tape.records.empty());
  for (size_t k = 0; k < ms.size(); ++k) times.stages[k] = {Median(ms[k]), bytes[k]};
  times.step_ms = Median(whole);
  times.visible = step.counts.visible;
  times.instances = step.counts.instances;
  return times;
}

double CopyGbs(size_t bytes, int copies) {
  cuda::CudaStream stream;
  Buffer<unsigned char> from, to;
  from.Refill(bytes, stream);
  to.Refill(bytes, stream);
  from.FillWithZeros(stream);
  std::vector<double> gbs;
  for (int c = 0; c < copies; ++c) {
    cuda::TimedEvent begin, end;
    begin.Record(stream);
    cuda::Check(
        cudaMemcpyAsync(to.data(), from.data(), bytes, cudaMemcpyDeviceToDevice, stream.get()),
        "cudaMemcpyAsync");
    end.Record(stream);
    gbs.push_back(2e-6 * double(bytes) / double(end.MillisecondsSince(begin)));
  }
  return Median(gbs);
}

}  // namespace cosplat::test
