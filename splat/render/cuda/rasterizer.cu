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
    if (depth.keys.count != 0) depth.Set(i, kernel.radii[i], kernel.splats[i]);
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

struct SetDepthKeys {
  DepthKeys depth;
  View<const float> radii;
  View<const ProjectedSplat> splats;
  __device__ void operator()(size_t i) const { depth.Set(i, radii[i], splats[i]); }
};

// depth: empty if nothing will be sorted.
void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats,
                   float* radii,
                   const DepthKeys& depth,
                   Stream& stream) {
  const auto project = [&](auto antialiased) {
    ForStagedBlocks(
        gaussians,
        stream,
        Project<decltype(antialiased)::value>{{}, {gaussians, view, splats, radii}, depth});
  };
  gaussians.antialiased ? project(std::true_type()) : project(std::false_type());
}

void LaunchProjectBack(const WorldGaussians& gaussians,
                       const ViewParameters& view,
                       const ProjectedSplat* splats,
                       const float* radii,
                       const SplatGradient* d_splats,
                       const WorldGradients& gradients,
                       Stream& stream) {
  const auto project_back = [&](auto antialiased) {
    ForStagedBlocks(gaussians,
                    stream,
                    ProjectBack<decltype(antialiased)::value>{
                        {}, {gaussians, view, splats, radii, d_splats, gradients}});
  };
  gaussians.antialiased ? project_back(std::true_type()) : project_back(std::false_type());
}

}  // namespace

// Uploads the constants of every basis once: copying from pageable memory makes the host wait for
// the stream.
CudaRasterizer::CudaRasterizer(SumOrder order) : order_(order) {
  std::vector<float> constants;
  for (size_t b = 0; b < kBasisNames.size(); ++b) {
    const float* of_basis = BasisConstants(Basis(b));
    constants.insert(constants.end(), of_basis, of_basis + kMaxCoefficients);
  }
  basis_constants_.Upload(constants, stream_);
}

ViewParameters CudaRasterizer::ViewIn(const Camera& camera, Basis basis, int degree) const {
  ViewParameters view = ViewOfCamera(camera, basis, degree);
  view.basis_constants = basis_constants_.data() + size_t(basis) * kMaxCoefficients;
  return view;
}

void CudaRasterizer::Forward(const WorldGaussians& gaussians,
                             Basis basis,
                             const Camera& camera,
                             const RenderSettings& settings,
                             RenderedImage& image,
                             RenderTape& base_tape) {
  CheckArguments(gaussians, camera, settings);
  auto& tape = static_cast<CudaTape&>(base_tape);
  tape.view = ViewIn(camera, basis, settings.degree);
  tape.splats.Refill(gaussians.count, stream_);
  tape.radius.Refill(gaussians.count, stream_);
  marks_[kStart].Record(stream_);
  const DepthKeys depth = tape.lists.Begin(gaussians.count, stream_);
  LaunchProject(gaussians, tape.view, tape.splats.data(), tape.radius.data(), depth, stream_);
  DrawLists(camera, settings, image, tape);
}

void CudaRasterizer::Project(const WorldGaussians& gaussians,
                             Basis basis,
                             const Camera& camera,
                             int degree,
                             ProjectedSplat* splats,
                             float* radii) {
  LaunchProject(gaussians, ViewIn(camera, basis, degree), splats, radii, {}, stream_);
}

void CudaRasterizer::Draw(const Camera& camera,
                          const RenderSettings& settings,
                          RenderedImage& image,
                          RenderTape& base_tape) {
  auto& tape = static_cast<CudaTape&>(base_tape);
  marks_[kStart].Record(stream_);
  const DepthKeys depth = tape.lists.Begin(tape.splats.size(), stream_);
  ForEachThread(tape.splats.size(), stream_, SetDepthKeys{depth, tape.radii(), tape.splats.view()});
  DrawLists(camera, settings, image, tape);
}

// From tape.splats and their depths on.
void CudaRasterizer::DrawLists(const Camera& camera,
                               const RenderSettings& settings,
                               RenderedImage& image,
                               CudaTape& tape) {
  tape.settings = settings;
  image.width = camera.width;
  image.height = camera.height;
  marks_[kProjected].Record(stream_);
  tape.lists.Build(std::as_const(tape.splats).view(), camera.width, camera.height, stream_);
  marks_[kSorted].Record(stream_);
  BlendForward(tape, image, stream_);
  marks_[kBlended].Record(stream_);
}

void CudaRasterizer::Backward(const WorldGaussians& gaussians,
                              const RenderedImage& image,
                              const Buffer<float>& d_color,
                              RenderTape& base_tape,
                              const WorldGradients& gradients) {
  auto& tape = static_cast<CudaTape&>(base_tape);
  DrawBackward(image, d_color, tape);
  LaunchProjectBack(gaussians,
                    tape.view,
                    tape.splats.data(),
                    tape.radius.data(),
                    tape.d_splats.data(),
                    gradients,
                    stream_);
  marks_[kBack].Record(stream_);
}

void CudaRasterizer::DrawBackward(const RenderedImage& image,
                                  const Buffer<float>& d_color,
                                  RenderTape& base_tape) {
  marks_[kBackStart].Record(stream_);
  BlendBackward(static_cast<CudaTape&>(base_tape), image, d_color.data(), stream_);
  marks_[kBlendedBack].Record(stream_);
  marks_[kBack].Record(stream_);
}

void CudaRasterizer::ProjectBackward(const WorldGaussians& gaussians,
                                     Basis basis,
                                     const Camera& camera,
                                     int degree,
                                     const ProjectedSplat* splats,
                                     const float* radii,
                                     const SplatGradient* d_splats,
                                     const WorldGradients& gradients) {
  const ViewParameters view = ViewIn(camera, basis, degree);
  LaunchProjectBack(gaussians, view, splats, radii, d_splats, gradients, stream_);
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
