#include "tests/gpu/avatar_times.h"

#include <chrono>

#include "avatar/play/cuda/device_avatar_renderer.h"
#include "avatar/play/cuda/device_poser.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/cuda/device_binding.h"
#include "splat/render/cuda/renderer.h"
#include "splat/train/cuda/adam.h"
#include "splat/train/cuda/loss.h"
#include "splat/train/loss.h"
#include "tests/gpu/made_avatar.h"

namespace cosplat::test {
namespace {

// A frame and a training step with everything on the device.
class DeviceAvatarStep {
 public:
  explicit DeviceAvatarStep(const MadeAvatar& made)
      : made_(made),
        poser_({made.flame.arrays, {}}, directions_, stream()),
        surface_(Surface(made.model.mesh), stream()) {
    gaussians_.Upload(made.model.gaussians, stream());
    gradients_.ResizeLike(gaussians_);
    embedding_.Upload(made.model, surface_.face_count(), stream());
    target_.Upload(made.photograph, stream());
    adam_.Start(gaussians_, stream());
    exceeded_.Refill(1);
    exceeded_.FillWithZeros(stream());
    rates_.rate = {1e-6f, 1e-5f, 1e-5f, 1e-4f, 1e-4f, 1e-5f};
    renderer_.stream().Wait();
  }

  const float* Pose(int frame) {
    return poser_.Pose(made_.rigs[size_t(frame) % kPoses], stream()).data();
  }
  void Draw(int frame) { Draw(Pose(frame), false); }

  void Train(int frame, bool track) {
    const std::vector<float>& posed = made_.poses[size_t(frame) % kPoses];
    vertices_.Upload(posed.data(), posed.size(), stream());
    Draw(vertices_.data(), true);
    Step(track);
  }
  void Wait() {
    if (readback_.Get(exceeded_.data(), stream()) != 0)
      throw Error("", "avatar", "a step had more instances than the frames before it");
  }

 private:
  // To train waits for nothing: as many instances as any frame had before, and some.
  void Draw(const float* vertices, bool keep) {
    surface_.Pose(vertices, stream());
    binding_.Bind(gaussians_, embedding_, surface_, posed_, stream());
    world_ = posed_.View(gaussians_, ColorFrame::kSurface);
    if (keep && most_ > 0) tape_.lists.Expect(most_ + most_ / 8, exceeded_.data());
    renderer_.Forward(
        world_, made_.model.gaussians.basis, made_.camera, made_.settings, keep, image_, tape_);
    most_ = std::max(most_, tape_.lists.instances());
  }

  void Step(bool track) {
    loss_.Evaluate({}, image_.color.data(), target_, {0, 0, 0}, d_color_, stream());
    d_posed_.Refill(gaussians_.size());
    WorldGradients d_world = gradients_.GradientView(screen_);
    d_world.position = d_posed_.position.data();
    d_world.rotation = d_posed_.rotation.data();
    d_world.scale_log = d_posed_.scale_log.data();
    d_world.color_frame = d_posed_.frame.data();
    renderer_.Backward(world_, image_, d_color_.data(), tape_, d_world);
    binding_.Backward(gaussians_,
                      embedding_,
                      surface_,
                      d_posed_,
                      gradients_,
                      track ? &d_vertices_ : nullptr,
                      stream());
    adam_.Step(
        rates_, gradients_, std::as_const(tape_.radii).view(), nullptr, gaussians_, stream());
    if (!track) return;
    d_vertices_on_host_.resize(d_vertices_.size());
    d_vertices_.Download(d_vertices_on_host_.data(), stream());
    Wait();
  }
  cudaStream_t stream() const { return renderer_.stream().get(); }

  const MadeAvatar& made_;
  cuda::Renderer renderer_{cuda::SumOrder::kAny};
  cuda::DirectionStore directions_;
  cuda::DevicePoser poser_;
  cuda::DeviceSurface surface_;
  cuda::DeviceGaussians gaussians_, gradients_;
  cuda::DeviceEmbedding embedding_;
  cuda::DeviceBinding binding_;
  cuda::DevicePosed posed_, d_posed_;
  cuda::DeviceBuffer<float> vertices_, d_vertices_, d_color_, screen_;
  std::vector<float> d_vertices_on_host_;
  WorldGaussians world_;
  cuda::DeviceImage image_;
  cuda::Tape tape_;
  cuda::DeviceTarget target_;
  cuda::PhotometricLoss loss_;
  cuda::Adam adam_;
  size_t most_ = 0;
  cuda::DeviceBuffer<uint32_t> exceeded_;
  cuda::Readback<uint32_t> readback_;
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
    WorldGaussians world = ViewOf(made.model.gaussians);
    world.position = posed.position.data();
    world.rotation = posed.rotation.data();
    world.scale_log = posed.scale_log.data();
    world.color_frame = posed.frame.data();
    rasterizer->Forward(
        world, made.model.gaussians.basis, made.camera, made.settings, image, *tape);
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
  const auto renderer = cuda::MakeDeviceRenderers()(made.model, {made.flame.arrays, {}});
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
