#include "splat/render/device.h"

#include "splat/base/error.h"
#include "splat/render/rasterizer.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/device/cuda/device.h"
#include "splat/render/cuda/rasterizer.h"
#endif

namespace cosplat {
namespace {

// Why CUDA is not available; empty if it is.
std::string WhyNoCuda() {
#if defined(COSPLAT_HAS_CUDA)
  return cuda::WhyNoDevice();
#else
  return "this program was built without CUDA";
#endif
}

}  // namespace

Device UsableDevice(std::optional<Device> wanted, const std::string& field) {
  if (wanted == Device::kCpu) return Device::kCpu;
  const std::string reason = WhyNoCuda();
  if (reason.empty()) return Device::kCuda;
  if (wanted) throw Error(field, "cuda: " + reason);
  return Device::kCpu;
}

std::unique_ptr<StagedRasterizer> MakeRasterizerOn(Device device, bool deterministic) {
  if (device == Device::kCpu) return MakeCpuRasterizer();
#if defined(COSPLAT_HAS_CUDA)
  cuda::ProvideRenderKernels();
  return std::make_unique<cuda::CudaRasterizer>(deterministic ? cuda::SumOrder::kFixed
                                                              : cuda::SumOrder::kAny);
#else
  (void)deterministic;
  throw Error("device", "cuda: " + WhyNoCuda());
#endif
}

std::unique_ptr<Rasterizer> MakeRasterizer(Device device) {
  std::unique_ptr<Rasterizer> rasterizer = MakeRasterizerOn(device, true);
  return device == Device::kCpu ? std::move(rasterizer)
                                : MakeCopyingRasterizer(std::move(rasterizer));
}

SceneRendererMaker SceneRendererOn(Device device) {
  if (device == Device::kCpu) return {};
  return [device](const Gaussians& scene) {
    return std::make_unique<SceneRenderer>(MakeRasterizerOn(device, false), scene);
  };
}

std::string NameOf(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  const auto gpu = device == Device::kCuda ? cuda::FindDevice() : std::nullopt;
  if (gpu) return gpu->name;
#endif
  return device == Device::kCpu ? "CPU" : "CUDA";
}

}  // namespace cosplat
