#include "splat/basis_constants.h"
#include "splat/device/cuda/kernels.cuh"
#include "splat/device/cuda/launch.cuh"
#include "splat/render/cuda/rasterizer.h"
#include "splat/render/cuda/staged_rest.cuh"
#include "splat/render/cuda/tape.h"
#include "splat/render/kernels/pixel_bytes.h"
#include "splat/render/kernels/project.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {
namespace {

// A block's threads each have a Gaussian; a warp's coefficients are in shared memory.
struct StagedBlock {
  static constexpr unsigned kThreads = kStagedThreads;
  static __device__ size_t Index() { return size_t(blockIdx.x) * kThreads + threadIdx.x; }
  static __device__ StagedRest RestOf(const WorldGaussians& g) {
    float* const shared = SharedArray<float>() + size_t(WarpInBlock()) * kWarp * g.rest_width;
    return {shared, g.rest_width, Index() - Lane(), g.count};
  }
};
template <class Body>
void ForStagedBlocks(const WorldGaussians& g, Stream& stream, const Body& body) {
  const size_t blocks = (g.count + kStagedThreads - 1) / kStagedThreads;
  ForBlocks(blocks, stream, body, sizeof(float) * kStagedThreads * size_t(g.rest_width));
}

template <bool kAntialiased>
struct Project : StagedBlock {
  math::ProjectKernel<kAntialiased> kernel;
  DepthKeys depth;

  __device__ void operator()() const {
    const size_t i = Index();
    const bool inside = i < kernel.gaussians.count;
    const StagedRest rest = RestOf(kernel.gaussians);
    rest.Load(kernel.gaussians.color_rest, __ballot_sync(kAllLanes, inside));
    if (!inside) return;
    math::ProjectKernel<kAntialiased> staged = kernel;
    staged.gaussians.color_rest = rest.rows();
    staged.template Run<float>(math::Rows{i, 1});
    depth.Set(i, kernel.radii[i], kernel.splats[i]);
  }
};

template <bool kAntialiased>
struct ProjectBack : StagedBlock {
  math::ProjectVjpKernel<kAntialiased> kernel;

  __device__ void operator()() const {
    const size_t i = Index();
    const bool inside = i < kernel.gaussians.count;
    const unsigned visible = __ballot_sync(kAllLanes, inside && kernel.radii[i] > 0);
    const bool group_visible = (visible >> GroupShift() & kOfGroup) != 0;
    const bool runs = inside && (group_visible || !kernel.out.drawn_groups_only);
    const StagedRest rest = RestOf(kernel.gaussians);
    rest.Load(kernel.gaussians.color_rest, __ballot_sync(kAllLanes, group_visible));
    if (runs) {
      // A thread reads all of its coefficients before it writes their gradients to the same place.
      math::ProjectVjpKernel<kAntialiased> staged = kernel;
      staged.gaussians.color_rest = staged.out.color_rest = rest.rows();
      staged.template Run<float>(math::Rows{i, 1});
    }
    rest.Store(kernel.out.color_rest, __ballot_sync(kAllLanes, runs));
  }

 private:
  static constexpr unsigned kOfGroup = (1u << kGaussianGroup) - 1;
  static __device__ unsigned GroupShift() {
    return Lane() / unsigned(kGaussianGroup) * unsigned(kGaussianGroup);
  }
};

}  // namespace

// Uploads the constants of every basis once: copying from pageable memory makes the host wait for
// the stream.
CudaRasterizer::CudaRasterizer(SumOrder order) : order_(order) {
  std::vector<float> constants;
  for (size_t b = 0; b < kBasisNames.size(); ++b) {
    const float* of_basis = BasisConstants(Basis(b));
    constants.insert(constants.end(), of_basis, of_basis + kMaxCoefficients);
  }
  basis_constants_.Upload(constants.data(), constants.size(), stream_);
}

void CudaRasterizer::Forward(const WorldGaussians& gaussians,
                             Basis basis,
                             const Camera& camera,
                             const RenderSettings& settings,
                             RenderedImage& image,
                             RenderTape& base_tape) {
  CheckArguments(gaussians, camera, settings);
  auto& tape = static_cast<CudaTape&>(base_tape);
  Stream& stream = stream_;
  tape.view = ViewOfCamera(camera, basis, settings.degree);
  tape.view.basis_constants = basis_constants_.data() + size_t(basis) * kMaxCoefficients;
  tape.settings = settings;
  image.width = camera.width;
  image.height = camera.height;
  tape.splats.Refill(gaussians.count, stream);
  tape.radius.Refill(gaussians.count, stream);
  marks_[kStart].Record(stream);
  const DepthKeys depth = tape.lists.Begin(gaussians.count, stream);
  const auto project = [&](auto antialiased) {
    ForStagedBlocks(gaussians,
                    stream,
                    Project<decltype(antialiased)::value>{
                        {}, {gaussians, tape.view, tape.splats.data(), tape.radius.data()}, depth});
  };
  gaussians.antialiased ? project(std::true_type()) : project(std::false_type());
  marks_[kProjected].Record(stream);
  tape.lists.Build(std::as_const(tape.splats).view(), camera.width, camera.height, stream);
  marks_[kSorted].Record(stream);
  BlendForward(tape, image, stream);
  marks_[kBlended].Record(stream);
}

void CudaRasterizer::Backward(const WorldGaussians& gaussians,
                              const RenderedImage& image,
                              const Buffer<float>& d_color,
                              RenderTape& base_tape,
                              const WorldGradients& gradients) {
  auto& tape = static_cast<CudaTape&>(base_tape);
  Stream& stream = stream_;
  marks_[kBackStart].Record(stream);
  BlendBackward(tape, image, d_color.data(), stream);
  marks_[kBlendedBack].Record(stream);
  const auto project_back = [&](auto antialiased) {
    ForStagedBlocks(gaussians,
                    stream,
                    ProjectBack<decltype(antialiased)::value>{{},
                                                              {gaussians,
                                                               tape.view,
                                                               tape.splats.data(),
                                                               tape.radius.data(),
                                                               tape.d_splats.data(),
                                                               gradients}});
  };
  gaussians.antialiased ? project_back(std::true_type()) : project_back(std::false_type());
  marks_[kBack].Record(stream);
}

void CudaRasterizer::Contributions(const RenderedImage& image,
                                   RenderTape& base_tape,
                                   Buffer<Contribution>& sums) {
  auto& tape = static_cast<CudaTape&>(base_tape);
  sums.Refill(tape.splats.size(), stream_);
  SumContributions(tape, image, sums.data(), stream_);
}

void CudaRasterizer::AddForwardTimes() {
  const auto add = [&](Phase phase, Mark from, Mark to) {
    times.seconds[size_t(phase)] += 1e-3 * MillisecondsBetween(from, to);
  };
  add(Phase::kProject, kStart, kProjected);
  add(Phase::kSort, kProjected, kSorted);
  add(Phase::kBlend, kSorted, kBlended);
}

void CudaRasterizer::AddBackwardTimes() {
  times.seconds[size_t(Phase::kBackward)] += 1e-3 * MillisecondsBetween(kBackStart, kBack);
}

void ProvideRenderKernels() {
  Provide<WritePixel<AlphaMode::kStraight>,
          WritePixel<AlphaMode::kPremultiplied>,
          WritePixel<AlphaMode::kOpaque>>();
}

}  // namespace cosplat::cuda
