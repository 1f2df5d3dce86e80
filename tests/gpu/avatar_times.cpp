#include "tests/gpu/avatar_times.h"

#include <chrono>

#include "avatar/play/avatar_renderer.h"
#include "avatar/play/rig_poser.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/cuda/kernels.h"
#include "splat/render/cuda/rasterizer.h"
#include "splat/train/cuda/kernels.h"
#include "splat/train/loss/loss.h"
#include "splat/train/optimize/optimizer.h"
#include "tests/gpu/made_avatar.h"

namespace cosplat::test {
namespace {

void ProvideKernels() {
  cuda::ProvideTrainKernels();
  cuda::ProvideAvatarKernels();
}

// A frame and a training step with everything on the device.
class DeviceAvatarStep {
 public:
  explicit DeviceAvatarStep(const MadeAvatar& made)
      : made_(made),
        poser_({made.flame.arrays, {}}, directions_, stream()),
        surface_(made.model.mesh, stream()),
        target_{made.photograph.width, made.photograph.height, made.photograph.channels},
        readback_(stream()) {
    const AdamState first(made.model.gaussians);
    gaussians_.Upload(made.model.gaussians, stream());
    gradients_.RefillLike(gaussians_, stream());
    UploadEmbedding(made.model.embedding, embedding_, stream());
    target_bytes_.Upload(made.photograph.data.data(), made.photograph.data.size(), stream());
    target_.bytes = target_bytes_.data();
    adam_.Upload(first, stream());
    exceeded_.Refill(1, stream());
    exceeded_.FillWithZeros(stream());
    rates_.rate = {1e-6f, 1e-5f, 1e-5f, 1e-4f, 1e-4f, 1e-5f};
    stream().Wait();
  }

  const Buffer<float>& Pose(int frame) {
    return poser_.Pose(made_.rigs[size_t(frame) % kPoses], stream());
  }
  void Draw(int frame) {
    Draw(Pose(frame), image_tape_);
    most_ = std::max(most_, image_tape_.capacity());  // which waits to have as many as there are
  }

  void Train(int frame, bool track) {
    const std::vector<float>& posed = made_.poses[size_t(frame) % kPoses];
    vertices_.Upload(posed.data(), posed.size(), stream());
    // Waits for nothing: as many instances as any image had before, and some.
    if (most_ > 0) tape_.lists.Expect(most_ + most_ / 8, exceeded_.data());
    Draw(vertices_, tape_);
    Step(track);
  }
  void Wait() {
    if (readback_.Get(exceeded_.data(), stream()) != 0)
      throw Error("", "avatar", "a step had more instances than the frames before it");
  }

 private:
  void Draw(const Buffer<float>& vertices, cuda::CudaTape& tape) {
    surface_.Pose(vertices);
    Bind(gaussians_, embedding_, surface_, posed_);
    world_ = PosedView(gaussians_, posed_, ColorFrame::kSurface);
    rasterizer_.Forward(world_, gaussians_.basis, made_.camera, made_.settings, image_, tape);
  }

  void Step(bool track) {
    loss_->Evaluate({}, image_.color, target_, {0, 0, 0}, d_color_, stream());
    d_posed_.Refill(gaussians_.size(), stream());
    WorldGradients d_world = GradientViewOf(gradients_, screen_, stream());
    d_world.position = d_posed_.position.data();
    d_world.rotation = d_posed_.rotation.data();
    d_world.scale_log = d_posed_.scale_log.data();
    d_world.color_frame = d_posed_.frame.data();
    rasterizer_.Backward(world_, image_, d_color_, tape_, d_world);
    BindBackward(gaussians_,
                 embedding_,
                 surface_,
                 d_posed_,
                 gradients_,
                 track ? &d_vertices_ : nullptr,
                 scratch_);
    AdamStepAll(rates_, gradients_, {}, tape_.radii(), gaussians_, adam_, stream());
    if (!track) return;
    d_vertices_on_host_.resize(d_vertices_.size());
    d_vertices_.Download(d_vertices_on_host_.data(), stream());
    Wait();
  }
  Stream& stream() { return rasterizer_.stream(); }

  const MadeAvatar& made_;
  cuda::CudaRasterizer rasterizer_{cuda::SumOrder::kAny};
  DirectionStore directions_;
  RigPoser poser_;
  Surface surface_;
  Gaussians gaussians_, gradients_;
  Embedding embedding_;
  PosedGaussians posed_, d_posed_;
  BindScratch scratch_;
  Buffer<float> vertices_, d_vertices_, d_color_, screen_;
  std::vector<float> d_vertices_on_host_;
  WorldGaussians world_;
  RenderedImage image_;
  cuda::CudaTape image_tape_{false, cuda::SumOrder::kAny}, tape_{true, cuda::SumOrder::kAny};
  Buffer<uint8_t> target_bytes_;
  TargetView target_;
  std::unique_ptr<StepLoss> loss_ = cuda::MakeCudaLoss();
  AdamState adam_;
  size_t most_ = 0;  // instances of an image
  Buffer<uint32_t> exceeded_;
  Readback<uint32_t> readback_;
  AdamSettings rates_;
};

// Mean of `count` calls after as many that are not counted.
template <class F, class Wait>
double MeanMs(int count, const F& f, const Wait& wait) {
  for (int i = 0; i < count; ++i) f(i);
  wait();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < count; ++i) f(i);
  wait();
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  return took.count() / count;
}

void MeasureCpu(const MadeAvatar& made, int count, AvatarTimes& times, RenderedImage& image) {
  Surface surface(made.model.mesh);
  PosedGaussians posed;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const auto draw = [&](int i) {
    surface.Pose(made.poses[size_t(i) % kPoses]);
    Bind(made.model, surface, posed);
    const Gaussians& gaussians = made.model.gaussians;
    rasterizer->Forward(PosedView(gaussians, posed, ColorFrame::kSurface),
                        gaussians.basis,
                        made.camera,
                        made.settings,
                        image,
                        *tape);
  };
  times.cpu_frame_ms = MeanMs(count, draw, [] {});
  draw(0);
}

}  // namespace

AvatarTimes TimeAvatar(bool tiny) {
  const MadeAvatar made = tiny ? MakeAvatar(200, 40, 1) : MakeAvatar(20000, 512, 5);
  const int count = tiny ? 1 : 400;
  AvatarTimes times;
  times.gaussians = made.model.size();
  times.triangles = made.model.mesh.faces.size();
  times.side = made.camera.width;
  RenderedImage on_cpu, on_device;
  MeasureCpu(made, tiny ? 1 : 20, times, on_cpu);
  ProvideKernels();
  const auto renderer = AvatarRendererOn(Device::kCuda)(made.model, {made.flame.arrays, {}});
  uint64_t placement = 0;
  const auto draw = [&](int i) {
    renderer->Draw(
        made.rigs[size_t(i) % kPoses], ++placement, made.camera, made.settings, on_device);
  };
  times.frame_to_host_ms = MeanMs(count, draw, [] {});
  draw(0);
  times.psnr = Psnr(on_device.color, on_cpu.color);
  DeviceAvatarStep step(made);
  const auto wait = [&] { step.Wait(); };
  times.pose_ms = MeanMs(
      count, [&](int i) { step.Pose(i); }, wait);
  times.frame_ms = MeanMs(
      count, [&](int i) { step.Draw(i); }, wait);
  times.step_ms = MeanMs(
      count, [&](int i) { step.Train(i, false); }, wait);
  times.step_and_track_ms = MeanMs(
      count, [&](int i) { step.Train(i, true); }, wait);
  return times;
}

void WriteJson(std::FILE* file, const AvatarTimes& t) {
  std::fprintf(file,
               "\"avatar\": {\"gaussians\": %zu, \"triangles\": %zu, \"side\": %d,\n"
               "  \"pose_ms\": %.4f, \"frame_ms\": %.4f, \"frames_per_s\": %.1f, "
               "\"frame_to_host_ms\": %.4f,\n"
               "  \"step_ms\": %.4f, \"steps_per_s\": %.1f, \"step_and_track_ms\": %.4f,\n"
               "  \"cpu_frame_ms\": %.4f, \"psnr_to_cpu\": %.2f}",
               t.gaussians,
               t.triangles,
               t.side,
               t.pose_ms,
               t.frame_ms,
               1e3 / t.frame_ms,
               t.frame_to_host_ms,
               t.step_ms,
               1e3 / t.step_ms,
               t.step_and_track_ms,
               t.cpu_frame_ms,
               t.psnr);
}

}  // namespace cosplat::test
