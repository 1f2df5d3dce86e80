// The rasteriser (splat/render/rasterizer.h) on a CUDA device.
//
// Uses a single stream. The host waits only in Forward, once, for the number of instances, and not
// even there if it was told how many to expect (RenderTape::Expect). The exponential is the
// hardware's own, regardless of RenderSettings::exp_degree.
#pragma once

#include "splat/device/cuda/stream.h"
#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {

class CudaRasterizer : public StagedRasterizer {
 public:
  explicit CudaRasterizer(SumOrder order);

  Stream& stream() override { return stream_; }
  std::unique_ptr<RenderTape> MakeTape(bool keep = true) const override {
    return std::make_unique<CudaTape>(keep, order_);
  }
  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings,
               RenderedImage& image,
               RenderTape& tape) override;
  void Backward(const WorldGaussians& gaussians,
                const RenderedImage& image,
                const Buffer<float>& d_color,
                RenderTape& tape,
                const WorldGradients& gradients) override;
  void Project(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               int degree,
               ProjectedSplat* splats,
               float* radii) override;
  void Draw(const Camera& camera,
            const RenderSettings& settings,
            RenderedImage& image,
            RenderTape& tape) override;
  void DrawBackward(const RenderedImage& image,
                    const Buffer<float>& d_color,
                    RenderTape& tape) override;
  void ProjectBackward(const WorldGaussians& gaussians,
                       Basis basis,
                       const Camera& camera,
                       int degree,
                       const ProjectedSplat* splats,
                       const float* radii,
                       const SplatGradient* d_splats,
                       const WorldGradients& gradients) override;
  void Contributions(const RenderedImage& image,
                     RenderTape& tape,
                     Buffer<Contribution>& contributions) override;
  double BytesPerGaussian(double instances) const override;
  void AddForwardTimes() override;
  void AddBackwardTimes() override;

  // Events between the stages of the last Forward and Backward, in order: project, sort, blend;
  // then blend backward, project backward. Valid once the caller has waited for the stream.
  enum Mark { kStart, kProjected, kSorted, kBlended, kBackStart, kBlendedBack, kBack, kMarks };
  float MillisecondsBetween(Mark from, Mark to) const {
    return marks_[to].MillisecondsSince(marks_[from]);
  }

 private:
  ViewParameters ViewIn(const Camera& camera, Basis basis, int degree) const;
  void DrawLists(const Camera& camera,
                 const RenderSettings& settings,
                 RenderedImage& image,
                 CudaTape& tape);

  SumOrder order_;
  CudaStream stream_;
  TimedEvent marks_[kMarks];
  Buffer<float> basis_constants_;  // [bases, kMaxCoefficients]
};

// Registers the kernels of splat/render/kernels/ that ForEach launches to run on a device.
void ProvideRenderKernels();

}  // namespace cosplat::cuda
