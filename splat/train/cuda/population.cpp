#include "splat/train/cuda/population.h"

namespace cosplat::cuda {

void Statistics::Reset(size_t n, cudaStream_t stream) {
  for (DeviceBuffer<float>* b : all()) {
    b->Refill(n);
    b->FillWithZeros(stream);
  }
}

void Statistics::Upload(const DensityStatistics& from, cudaStream_t stream) {
  screen_gradient.Upload(from.screen_gradient.data(), from.screen_gradient.size(), stream);
  plasticity.Upload(from.plasticity.data(), from.plasticity.size(), stream);
  visible.Upload(from.visible.data(), from.visible.size(), stream);
}

void Statistics::Download(DensityStatistics& to, cudaStream_t stream) {
  to.Reset(visible.size());
  screen_gradient.Download(to.screen_gradient.data(), stream);
  plasticity.Download(to.plasticity.data(), stream);
  visible.Download(to.visible.data(), stream);
}

void Population::Upload(const TrainingState& state, cudaStream_t stream) {
  values.Upload(state.gaussians, stream);
  gradients.ResizeLike(values);
  statistics.Upload(state.statistics, stream);
  adam.Start(values, stream);
  adam.m.Upload(state.adam.m, stream);
  adam.v.Upload(state.adam.v, stream);
  const std::vector<uint32_t> updated(state.adam.updated.begin(), state.adam.updated.end());
  adam.updated.Upload(updated.data(), updated.size(), stream);
  adam.step = uint32_t(state.adam.step);
  overflowed.Refill(1);
  GoOn(stream);
  adam.overflowed = overflowed.data();
  ignored_before_ = state.ignored_gradients;
}

void Population::DownloadForRanking(TrainingState& state, cudaStream_t stream) {
  state.gaussians.Resize(size());
  for (int a = 0; a < kAttributeCount; ++a)
    if (a != kColorRest) values.values[a].Download(state.gaussians.values[a].data(), stream);
  if (!values.degrees.empty()) {
    state.gaussians.degrees.resize(size());
    values.degrees.Download(state.gaussians.degrees.data(), stream);
  }
  statistics.Download(state.statistics, stream);
  Check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
}

void Population::Download(TrainingState& state, cudaStream_t stream) {
  std::vector<uint32_t> updated(adam.updated.size());
  state.adam.m.Resize(size());
  state.adam.v.Resize(size());
  adam.m.Download(state.adam.m, stream);
  adam.v.Download(state.adam.v, stream);
  adam.updated.Download(updated.data(), stream);
  state.gaussians.Resize(size());
  values.values[kColorRest].Download(state.gaussians.values[kColorRest].data(), stream);
  DownloadForRanking(state, stream);
  state.adam.updated.assign(updated.begin(), updated.end());
  state.adam.step = adam.step;
  state.ignored_gradients = ignored_before_ + adam.IgnoredGradients(stream);
}

std::vector<MemoryPart> Population::Memory() const {
  const auto held = [](const DeviceGaussians& g) {
    size_t bytes = HeldBy(g.degrees);
    for (const DeviceBuffer<float>& v : g.values) bytes += HeldBy(v);
    return bytes;
  };
  return {{"parameters", held(values)},
          {"gradients", held(gradients)},
          {"first moments", held(adam.m)},
          {"second moments", held(adam.v)},
          {"groups of Adam", HeldBy(adam.updated)},
          {"learned mask", mask.held()},
          {"density statistics",
           HeldBy(statistics.screen_gradient,
                  statistics.plasticity,
                  statistics.visible,
                  spare_,
                  spare_degrees_)}};
}

}  // namespace cosplat::cuda
