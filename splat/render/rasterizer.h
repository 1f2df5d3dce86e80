// The differentiable renderer: Gaussians + camera -> image, and its backward pass.
//
// Forward fills an image and a tape; Backward takes the tape and dL/d(image) and writes the
// gradients of every Gaussian. All arrays are in the memory of the rasteriser's stream. On the CPU,
// results are bit-identical for any number of threads. Source: Kerbl et al. 2023; back ends:
// splat/render/cpu/, splat/render/cuda/.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/basis.h"
#include "splat/config.h"
#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/render/contribution.h"
#include "splat/render/kernels/projected_splat.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/render/phase_times.h"

namespace cosplat {

// Planar image, written by the renderer and read by the loss.
struct RenderedImage {
  int width = 0;
  int height = 0;
  Buffer<float> color;          // [3, height, width] over the background, not clamped
  Buffer<float> transmittance;  // [height, width] visible share of the background, 1 - alpha

  // RGB; or RGBA with straight alpha and no background (requires an image rendered over black).
  Image ToImage() const;
  Image ToStraightAlpha() const;

  // Copy between a stream's memory and `host`, in host memory. The caller waits for the stream.
  void Upload(const RenderedImage& host, Stream& stream);
  void Download(RenderedImage& host, Stream& stream) const;
};

struct RenderSettings {
  std::array<float, 3> background{0, 0, 0};  // sRGB
  int degree = 0;                            // highest band evaluated; at most the stored one
  int exp_degree = kMaxExpDegree;            // of the blend loop's exponential (splat/config.h)
};

// Numbers of (Gaussian, tile) pairs and of visible Gaussians in a view.
struct InstanceCounts {
  uint64_t instances = 0, visible = 0;
};

// What Backward needs from Forward. Reuse one tape for many steps: it keeps its memory.
class RenderTape {
 public:
  virtual ~RenderTape() = default;
  // [count] radius in px (3 standard deviations), 0 for invisible Gaussians.
  View<const float> radii() const { return radius.view(); }
  // [1] counts of the last Forward, in the stream's memory.
  virtual const InstanceCounts* counts() const = 0;
  virtual std::vector<MemoryPart> Memory() const = 0;

  // Forward must know the number of instances before it can list them, and with a device the host
  // waits for it. Expect avoids the wait: the next Forward allocates capacity for `instances` and,
  // on overflow, sets *exceeded (in the stream's memory) to 1 and renders no Gaussians. Returns
  // false if that is not possible: without a device, or without enough memory for the prediction.
  virtual bool Expect(size_t /*instances*/, uint32_t* /*exceeded*/) { return false; }
  // Number of instances that the last Forward had capacity for.
  virtual size_t capacity() const = 0;

  // In the stream's memory, [count].
  Buffer<float> radius;
  Buffer<ProjectedSplat> splats;   // any values where invisible
  Buffer<SplatGradient> d_splats;  // of DrawBackward; likewise
};

class Rasterizer {
 public:
  virtual ~Rasterizer() = default;
  virtual Stream& stream() = 0;
  // keep: for Backward or Contributions, which cost a device 128 bytes per instance.
  virtual std::unique_ptr<RenderTape> MakeTape(bool keep = true) const = 0;

  // Throws Error if the image has no pixels, settings.degree exceeds the stored one or
  // settings.exp_degree is not supported. Gaussians with non-finite parameters are not rendered.
  virtual void Forward(const WorldGaussians& gaussians,
                       Basis basis,
                       const Camera& camera,
                       const RenderSettings& settings,
                       RenderedImage& image,
                       RenderTape& tape) = 0;

  // d_color: [3, height, width]. Overwrites every gradient (with zero for invisible Gaussians);
  // with gradients.drawn_groups_only, only those of groups (kGaussianGroup) with a visible
  // Gaussian.
  virtual void Backward(const WorldGaussians& gaussians,
                        const RenderedImage& image,
                        const Buffer<float>& d_color,
                        RenderTape& tape,
                        const WorldGradients& gradients) = 0;

  // Contribution of every Gaussian to the image that Forward rendered (with kMaxExpDegree), summed
  // over its pixels; 0 for invisible Gaussians. contributions: [count], overwritten.
  virtual void Contributions(const RenderedImage& image,
                             RenderTape& tape,
                             Buffer<Contribution>& contributions) = 0;

  // Tape memory in bytes per Gaussian, given the instances per Gaussian in the fullest view;
  // training on a device uses it to stay within memory.
  virtual double BytesPerGaussian(double /*instances*/) const { return 0; }

  // Times of project, sort, blend and backward; the caller resets them. Those of a device are added
  // only by AddForwardTimes and AddBackwardTimes, after its stream has been waited for.
  PhaseTimes times;
  virtual void AddForwardTimes() {}
  virtual void AddBackwardTimes() {}
};

// A rasteriser whose stages can be run apart, as where Gaussians are projected by one process and
// drawn by another. Forward is Project, then Draw; Backward is DrawBackward, then ProjectBackward.
// Arguments are those of Forward, already checked by Draw's caller (CheckArguments).
class StagedRasterizer : public Rasterizer {
 public:
  // radii: [count], 0 for invisible Gaussians; splats: [count], any values for these.
  virtual void Project(const WorldGaussians& gaussians,
                       Basis basis,
                       const Camera& camera,
                       int degree,
                       ProjectedSplat* splats,
                       float* radii) = 0;
  // Draws tape.splats where tape.radius is positive.
  virtual void Draw(const Camera& camera,
                    const RenderSettings& settings,
                    RenderedImage& image,
                    RenderTape& tape) = 0;
  // Fills tape.d_splats.
  virtual void DrawBackward(const RenderedImage& image,
                            const Buffer<float>& d_color,
                            RenderTape& tape) = 0;
  // splats, radii: of Project with the same arguments. gradients: as those of Backward.
  virtual void ProjectBackward(const WorldGaussians& gaussians,
                               Basis basis,
                               const Camera& camera,
                               int degree,
                               const ProjectedSplat* splats,
                               const float* radii,
                               const SplatGradient* d_splats,
                               const WorldGradients& gradients) = 0;
};

std::unique_ptr<StagedRasterizer> MakeCpuRasterizer();

// Non-owning views; kPosition must be a point in the world (for avatars: see
// avatar/surface/binding.h).
WorldGaussians ViewOf(const Gaussians& gaussians);
WorldGradients GradientViewOf(Gaussians& gradients,
                              Buffer<float>& screen,
                              Stream& stream = HostStream());

// What the element-wise kernels need to know of a camera. Colours use the bands up to `degree`.
ViewParameters ViewOfCamera(const Camera& camera, Basis basis, int degree);

// Throws Error as specified by Rasterizer::Forward, for both back ends.
void CheckArguments(const WorldGaussians& gaussians,
                    const Camera& camera,
                    const RenderSettings& settings);

// Wraps a device's rasteriser for arrays in host memory. For single images: every call copies
// everything to the device and back.
std::unique_ptr<Rasterizer> MakeCopyingRasterizer(std::unique_ptr<Rasterizer> on_device);

}  // namespace cosplat
