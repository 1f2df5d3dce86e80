// The training step on a device beside the CPU's, on the same views; see tests/gpu/run.sh.
//   cosplat_bench_cuda --out FILE.json [--image FILE.ppm] [--tiny]
// --tiny: one view of a few hundred Gaussians, to see that it works.
//   cosplat_bench_cuda scene FILE ...   a whole training: scene_times.h
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "apps/study/bench/synthetic_view.h"
#include "splat/base/error.h"
#include "splat/device/cuda/device.h"
#include "splat/media/image_io.h"
#include "splat/train/loss/loss.h"
#include "tests/gpu/avatar_times.h"
#include "tests/gpu/scene_times.h"
#include "tests/gpu/stage_times.h"
#include "tests/gpu/training_times.h"

namespace cosplat::test {
namespace {

struct Size {
  size_t gaussians = 0;
  int width = 0, height = 0;
};
// An avatar's video; the size of 3DGS's synthetic scenes; an image.
const std::vector<Size> kSizes{{20000, 512, 512}, {200000, 800, 800}, {2000000, 1600, 1064}};
const std::vector<Size> kTinySizes{{300, 48, 40}};
constexpr int kSteps = 50, kTinySteps = 1;
constexpr double kCpuSeconds = 15;  // at most, per view, but for one step

struct Options {
  std::string out, picture;
  bool tiny = false;
};

struct Result {
  Size size;
  StepTimes any, fixed;
  TrainingComparison training;
  double cpu_ms = 0, psnr = 0, cosine = 0;
  bool same_bits = false;
};

AdamSettings Rates() {
  AdamSettings settings;
  settings.rate = {1e-5f, 1e-3f, 5e-3f, 5e-2f, 2.5e-3f, 1.25e-4f};
  return settings;
}

RenderSettings Settings(const SyntheticView& view) { return {{0, 0, 0}, view.start.degree}; }

std::unique_ptr<DeviceStep> StepOn(const SyntheticView& view, cuda::SumOrder order) {
  return std::make_unique<DeviceStep>(
      view.start, view.frame.camera, view.frame.target, Settings(view), Rates(), order);
}

// A step on the CPU, and what it leaves to compare with.
struct CpuStep {
  explicit CpuStep(const SyntheticView& view)
      : view(view), gaussians(view.start), gradients(view.start.ZerosLike()), adam(view.start) {}

  void Run() {
    const WorldGaussians world = ViewOf(gaussians);
    rasterizer->Forward(world, gaussians.basis, view.frame.camera, Settings(view), image, *tape);
    loss.Evaluate({}, image.color, view.frame.target, {0, 0, 0}, d_color);
    WorldGradients out = GradientViewOf(gradients, screen);
    out.drawn_groups_only = true;
    rasterizer->Backward(world, image, d_color, *tape, out);
    AdamStepAll(Rates(), gradients, {}, tape->radii(), gaussians, adam);
  }

  const SyntheticView& view;
  std::unique_ptr<Rasterizer> rasterizer = MakeCpuRasterizer();
  std::unique_ptr<RenderTape> tape = rasterizer->MakeTape();
  Gaussians gaussians, gradients;
  AdamState adam;
  RenderedImage image;
  PhotometricLoss loss;
  Buffer<float> d_color, screen;
};

double FastestCpuStepMs(CpuStep& step) {
  double fastest = 1e30, total = 0;
  while (total < kCpuSeconds && fastest > kCpuSeconds * 1e-3) {
    const auto start = std::chrono::steady_clock::now();
    step.Run();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    fastest = std::min(fastest, seconds.count());
    total += seconds.count();
  }
  return 1e3 * fastest;
}

// The device's first image and gradients beside the CPU's.
void CompareFirstStep(const SyntheticView& view, CpuStep& cpu, Result& result) {
  cpu.Run();
  const auto device = StepOn(view, cuda::SumOrder::kFixed);
  device->gradients.FillWithZeros(device->stream());  // of groups that are left alone
  device->Draw();
  device->Compare();
  device->Backward();
  Buffer<float> color(device->image.color.size());
  Gaussians gradients = view.start;
  device->image.color.Download(color.data(), device->stream());
  device->gradients.Download(gradients, device->stream());
  device->stream().Wait();
  result.psnr = Psnr(color, cpu.image.color);
  double aa = 0, bb = 0, ab = 0;
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < gradients.values[a].size(); ++i) {
      const double x = cpu.gradients.values[a][i], y = gradients.values[a][i];
      aa += x * x;
      bb += y * y;
      ab += x * y;
    }
  result.cosine = ab / std::sqrt(aa * bb);
}

// Whether two runs of a few steps end with the same numbers.
bool EndsInTheSameBits(const SyntheticView& view, int steps) {
  Gaussians ends[2] = {view.start, view.start};
  for (Gaussians& end : ends) {
    const auto step = StepOn(view, cuda::SumOrder::kFixed);
    for (int s = 0; s < steps; ++s) step->Run();
    step->gaussians.Download(end, step->stream());
    step->stream().Wait();
  }
  for (int a = 0; a < kAttributeCount; ++a)
    if (std::memcmp(ends[0].values[a].data(),
                    ends[1].values[a].data(),
                    ends[0].values[a].size() * sizeof(float)) != 0)
      return false;
  return true;
}

void WritePpm(const std::string& path, const Image8& rgb) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) throw Error(path, "", "cannot be written");
  std::fprintf(file, "P6\n%d %d\n255\n", rgb.width, rgb.height);
  std::fwrite(rgb.data.data(), 1, rgb.data.size(), file);
  std::fclose(file);
}

Result Measure(const Size& size, const Options& o) {
  const SyntheticView view = MakeSyntheticView(size.gaussians, size.width, size.height, 1);
  Result result;
  result.size = size;
  {
    CpuStep cpu(view);
    CompareFirstStep(view, cpu, result);
    result.cpu_ms = FastestCpuStepMs(cpu);
  }
  const int steps = o.tiny ? kTinySteps : kSteps;
  const auto any = StepOn(view, cuda::SumOrder::kAny);
  result.any = TimeSteps(*any, steps);
  result.fixed = TimeSteps(*StepOn(view, cuda::SumOrder::kFixed), steps);
  result.same_bits = EndsInTheSameBits(view, o.tiny ? 2 : 20);
  result.training = CompareTraining(view, steps);
  if (!o.picture.empty()) {
    RenderedImage image{size.width, size.height, Buffer<float>(any->image.color.size()), {}};
    any->image.color.Download(image.color.data(), any->stream());
    any->stream().Wait();
    WritePpm(o.picture, ToBytes(image.ToImage()));
  }
  return result;
}

void WriteStages(std::FILE* file, const char* name, const StepTimes& times, double copy_gbs) {
  std::fprintf(file, "     \"%s\": {\"step_ms\": %.4f, \"stages\": {", name, times.step_ms);
  for (size_t k = 0; k < kStageNames.size(); ++k) {
    const Stage& s = times.stages[k];
    const double gbs = 1e-6 * s.bytes / s.ms;
    std::fprintf(file,
                 "%s\n       \"%s\": {\"ms\": %.4f, \"gb_per_s\": %.1f, \"share_of_copy\": %.3f}",
                 k ? "," : "",
                 kStageNames[k],
                 s.ms,
                 gbs,
                 gbs / copy_gbs);
  }
  std::fprintf(file, "}}");
}

void WriteJson(const std::string& path,
               const cuda::DeviceInfo& device,
               double copy_gbs,
               const AvatarTimes& avatar,
               const std::vector<Result>& results) {
  std::FILE* file = std::fopen((path + ".part").c_str(), "w");
  if (!file) throw Error(path, "", "cannot be written");
  std::fprintf(
      file,
      "{\"device\": \"%s\", \"compute_capability\": \"%d.%d\", \"copy_gb_per_s\": %.1f,\n ",
      device.name.c_str(),
      device.major,
      device.minor,
      copy_gbs);
  WriteJson(file, avatar);
  std::fprintf(file, ",\n \"cases\": [");
  for (size_t i = 0; i < results.size(); ++i) {
    const Result& r = results[i];
    std::fprintf(file,
                 "%s\n    {\"gaussians\": %zu, \"width\": %d, \"height\": %d, \"visible\": %zu,"
                 " \"instances\": %zu,\n     \"cpu_step_ms\": %.3f, \"ratio\": %.2f,"
                 " \"psnr_to_cpu\": %.2f, \"gradient_cosine\": %.9f, \"same_bits\": %s,\n",
                 i ? "," : "",
                 r.size.gaussians,
                 r.size.width,
                 r.size.height,
                 r.any.visible,
                 r.any.instances,
                 r.cpu_ms,
                 r.cpu_ms / r.any.step_ms,
                 r.psnr,
                 r.cosine,
                 r.same_bits ? "true" : "false");
    WriteJson(file, r.training);
    WriteStages(file, "any_order", r.any, copy_gbs);
    std::fprintf(file, ",\n");
    WriteStages(file, "fixed_order", r.fixed, copy_gbs);
    std::fprintf(file, "}");
  }
  std::fprintf(file, "]}\n");
  std::fclose(file);
  if (std::rename((path + ".part").c_str(), path.c_str()) != 0)
    throw Error(path, "", "cannot be written");
}

void Print(const Result& r) {
  std::printf(
      "%zu Gaussians, %dx%d, %zu instances: %.3f ms a step (fixed order %.3f), CPU %.1f ms;"
      " PSNR to the CPU %.1f dB, cosine of gradients %.7f, fixed order %s\n",
      r.size.gaussians,
      r.size.width,
      r.size.height,
      r.any.instances,
      r.any.step_ms,
      r.fixed.step_ms,
      r.cpu_ms,
      r.psnr,
      r.cosine,
      r.same_bits ? "gives the same bits" : "DIFFERS BETWEEN RUNS");
  for (size_t k = 0; k < kStageNames.size(); ++k)
    std::printf("  %-13s %8.3f ms %8.0f GB/s\n",
                kStageNames[k],
                r.any.stages[k].ms,
                1e-6 * r.any.stages[k].bytes / r.any.stages[k].ms);
}

// Far below what any right image and gradient give, far above what a wrong one does.
constexpr double kMinPsnr = 50;
bool IsRight(const Result& r) { return r.same_bits && r.psnr > kMinPsnr && r.cosine > 0.999; }

int Run(const Options& o) {
  const auto device = cuda::FindDevice();
  if (!device) throw Error("", "CUDA", "no device");
  const double copy_gbs = CopyGbs(o.tiny ? 1 << 16 : size_t(1) << 31, 5);
  std::printf("%s: copies %.0f GB/s\n", device->name.c_str(), copy_gbs);
  const AvatarTimes avatar = TimeAvatar(o.tiny);
  std::printf(
      "avatar, %zu Gaussians, %dx%d: %.0f frames/s, %.0f training steps/s; CPU %.0f frames/s;"
      " PSNR to the CPU %.1f dB\n",
      avatar.gaussians,
      avatar.side,
      avatar.side,
      1e3 / avatar.frame_ms,
      1e3 / avatar.step_ms,
      1e3 / avatar.cpu_frame_ms,
      avatar.psnr);
  std::vector<Result> results;
  bool right = avatar.psnr > kMinPsnr;
  for (const Size& size : o.tiny ? kTinySizes : kSizes) {
    results.push_back(Measure(size, o));
    Print(results.back());
    right &= IsRight(results.back());
    WriteJson(
        o.out, *device, copy_gbs, avatar, results);  // after each: a limit of time may end the run
  }
  return right ? 0 : 1;
}

Options Parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--tiny")
      o.tiny = true;
    else if ((name == "--out" || name == "--image") && i + 1 < argc)
      (name == "--out" ? o.out : o.picture) = argv[++i];
    else
      throw Error("", name, "is not known, or lacks its value");
  }
  if (o.out.empty()) throw Error("", "--out", "is needed");
  return o;
}

}  // namespace
}  // namespace cosplat::test

int main(int argc, char** argv) {
  try {
    if (argc > 1 && std::string(argv[1]) == "scene") {
      cosplat::test::RunSceneBench({argv + 2, argv + argc});
      return 0;
    }
    return cosplat::test::Run(cosplat::test::Parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cosplat_bench_cuda: %s\n", error.what());
    return 2;
  }
}
