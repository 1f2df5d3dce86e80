#include "splat/basis_constants.h"
#include "splat/device/cuda/launch.cuh"
#include "splat/render/cuda/blend_forward.h"
#include "splat/render/cuda/renderer.h"
#include "splat/render/kernels/project.h"
#include "splat/render/kernels/view_parameters.h"

namespace cosplat::cuda {
namespace {

struct Project {
  math::ProjectKernel kernel;
  __device__ void operator()(size_t i) const { kernel.Run<float>(math::Rows{i, 1}); }
};

struct ProjectBack {
  math::ProjectVjpKernel kernel;
  __device__ void operator()(size_t i) const {
    if (kernel.out.drawn_groups_only && !GroupIsDrawn(i)) return;
    kernel.Run<float>(math::Rows{i, 1});
  }
  __device__ bool GroupIsDrawn(size_t i) const {
    const size_t begin = i / kGaussianGroup * kGaussianGroup;
    const size_t end = math::Min(begin + kGaussianGroup, kernel.gaussians.count);
    for (size_t k = begin; k < end; ++k)
      if (kernel.radii[k] > 0) return true;
    return false;
  }
};

}  // namespace

// Every basis once and for all: copying from ordinary memory makes the host wait for the stream.
Renderer::Renderer(SumOrder order) : order_(order) {
  std::vector<float> constants;
  for (size_t b = 0; b < kBasisNames.size(); ++b) {
    const float* of_basis = BasisConstants(Basis(b));
    constants.insert(constants.end(), of_basis, of_basis + kMaxCoefficients);
  }
  basis_constants_.Upload(constants.data(), constants.size(), stream_.get());
}

void Renderer::Forward(const WorldGaussians& gaussians,
                       Basis basis,
                       const Camera& camera,
                       const RenderSettings& settings,
                       bool keep,
                       DeviceImage& image,
                       Tape& tape) {
  CheckArguments(gaussians, camera, settings);
  const cudaStream_t stream = stream_.get();
  tape.view = ViewOfCamera(camera, basis, settings.degree);
  tape.view.basis_constants = basis_constants_.data() + size_t(basis) * kMaxCoefficients;
  tape.settings = settings;
  tape.kept = keep;
  image.width = camera.width;
  image.height = camera.height;
  tape.splats.Refill(gaussians.count);
  tape.radii.Refill(gaussians.count);
  marks_[kStart].Record(stream);
  ForEach(gaussians.count,
          stream,
          Project{{gaussians, tape.view, tape.splats.data(), tape.radii.data()}});
  marks_[kProjected].Record(stream);
  tape.lists.Build(std::as_const(tape.splats).view(),
                   std::as_const(tape.radii).view(),
                   camera.width,
                   camera.height,
                   stream);
  marks_[kSorted].Record(stream);
  BlendForward(tape, image, stream);
  marks_[kBlended].Record(stream);
}

void Renderer::Backward(const WorldGaussians& gaussians,
                        const DeviceImage& image,
                        const float* d_color,
                        Tape& tape,
                        const WorldGradients& gradients) {
  const cudaStream_t stream = stream_.get();
  marks_[kBackStart].Record(stream);
  BlendBackward(tape, image, d_color, order_, stream);
  marks_[kBlendedBack].Record(stream);
  ForEach(gaussians.count,
          stream,
          ProjectBack{{gaussians,
                       tape.view,
                       tape.splats.data(),
                       tape.radii.data(),
                       tape.d_splats.data(),
                       gradients}});
  marks_[kBack].Record(stream);
}

void Renderer::Contributions(const DeviceImage& image,
                             Tape& tape,
                             DeviceBuffer<Contribution>& sums) {
  sums.Refill(tape.splats.size());
  SumContributions(tape, image, sums.data(), stream_.get());
}

std::vector<MemoryPart> Tape::Memory() const {
  return {{"projected splats", HeldBy(splats, radii)},
          {"tile lists", lists.HeldForGaussians()},
          {"gradients per splat and tile", HeldBy(records, contributions)},
          {"gradients per splat", HeldBy(d_splats)},
          {"pixels per bucket of splats", HeldBy(checkpoints)},
          {"tiles", lists.HeldForTiles() + HeldBy(n_contrib), MemoryOf::kPixels}};
}

}  // namespace cosplat::cuda
