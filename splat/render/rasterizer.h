// The differentiable renderer: Gaussians + camera -> image, and back.
//
// Forward fills an image and a tape; Backward takes the tape and dL/d(image) and writes the
// gradients of every Gaussian. All arrays are in the memory of the rasteriser's stream. On the CPU,
// results are the same bits for any number of threads. Source: Kerbl et al. 2023; back ends:
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
#include "splat/render/kernels/world_gaussians.h"
#include "splat/render/phase_times.h"

namespace cosplat {

// Planar image as the renderer writes and the loss reads it.
struct RenderedImage {
  int width = 0;
  int height = 0;
  Buffer<float> color;          // [3, height, width] over the background, not clamped
  Buffer<float> transmittance;  // [height, width] share of the background seen; 1 - alpha

  // RGB, or RGBA with straight alpha over no background (requires a black background).
  Image ToImage() const;
  Image ToStraightAlpha() const;

  // Between a stream's memory and the host's, which is `host`; waited for by the caller.
  void Upload(const RenderedImage& host, Stream& stream);
  void Download(RenderedImage& host, Stream& stream) const;
};

struct RenderSettings {
  std::array<float, 3> background{0, 0, 0};  // sRGB
  int degree = 0;                            // bands evaluated; at most those stored
  int exp_degree = kMaxExpDegree;            // of the blend loop's exponential (splat/config.h)
};

// (Gaussian, tile) pairs of a view, and Gaussians that it shows.
struct InstanceCounts {
  uint64_t instances = 0, visible = 0;
};

// What Backward needs of a Forward. Reuse one tape for many steps: it keeps its memory.
class RenderTape {
 public:
  virtual ~RenderTape() = default;
  // [count] radius in px (3 standard deviations), 0 for Gaussians that were not drawn.
  virtual View<const float> radii() const = 0;
  // [1] of the last Forward, in the stream's memory.
  virtual const InstanceCounts* counts() const = 0;
  virtual std::vector<MemoryPart> Memory() const = 0;

  // Forward has to know how many instances there are before it can list them, and a device's host
  // waits for that. It does not where it was told how many to expect: the next Forward makes room
  // for so many and, where there are more, sets *exceeded (the stream's) to 1 and draws none.
  // Returns false where that is not possible: no device, or no memory for the guess.
  virtual bool Expect(size_t instances, uint32_t* exceeded) {
    (void)instances;
    (void)exceeded;
    return false;
  }
  // Instances that the last Forward had room for.
  virtual size_t capacity() const = 0;
};

class Rasterizer {
 public:
  virtual ~Rasterizer() = default;
  virtual Stream& stream() = 0;
  // keep: for Backward or Contributions, for which a device keeps 128 bytes per instance.
  virtual std::unique_ptr<RenderTape> MakeTape(bool keep = true) const = 0;

  // Throws Error when the image has no pixels, the settings' degree is not stored or there is no
  // exponential of their degree.
  // Gaussians with NaN or infinite numbers are not drawn.
  virtual void Forward(const WorldGaussians& gaussians,
                       Basis basis,
                       const Camera& camera,
                       const RenderSettings& settings,
                       RenderedImage& image,
                       RenderTape& tape) = 0;

  // d_color: [3, height, width]. Overwrites every gradient (zero where not drawn); with
  // gradients.drawn_groups_only, those of groups of kGaussianGroup of which one was drawn.
  virtual void Backward(const WorldGaussians& gaussians,
                        const RenderedImage& image,
                        const Buffer<float>& d_color,
                        RenderTape& tape,
                        const WorldGradients& gradients) = 0;

  // What every Gaussian does for the image that Forward made (with the full exponential), summed
  // over its pixels; 0 where it was not drawn. contributions: [count], overwritten.
  virtual void Contributions(const RenderedImage& image,
                             RenderTape& tape,
                             Buffer<Contribution>& contributions) = 0;

  // Bytes of tapes per Gaussian where each has so many instances in the fullest view: what training
  // on a device reckons with.
  virtual double BytesPerGaussian(double instances) const {
    (void)instances;
    return 0;
  }

  // Project, sort, blend, backward; the caller resets it. A device adds its own when it is asked to
  // and has been waited for.
  PhaseTimes times;
  virtual void AddForwardTimes() {}
  virtual void AddBackwardTimes() {}
};

std::unique_ptr<Rasterizer> MakeCpuRasterizer();

// Borrowing views; kPosition must be a point in the world (for avatars: see
// avatar/surface/binding.h).
WorldGaussians ViewOf(const Gaussians& gaussians);
WorldGradients GradientViewOf(Gaussians& gradients,
                              Buffer<float>& screen,
                              Stream& stream = HostStream());

// What the element-wise kernels need of a camera, and what both back ends refuse to draw.

// Colours of bands up to `degree`.
ViewParameters ViewOfCamera(const Camera& camera, Basis basis, int degree);

// Throws Error as Rasterizer::Forward says.
void CheckArguments(const WorldGaussians& gaussians,
                    const Camera& camera,
                    const RenderSettings& settings);

// A rasteriser of arrays in the host's memory by one of a device.

// For single images: everything is copied there and back with each call.
std::unique_ptr<Rasterizer> MakeCopyingRasterizer(std::unique_ptr<Rasterizer> on_device);

}  // namespace cosplat
