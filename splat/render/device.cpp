#include "splat/render/device.h"

#include "splat/base/error.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/device/cuda/device.h"
#include "splat/render/cuda/cuda_rasterizer.h"
#include "splat/render/cuda/device_scene.h"
#endif

namespace cosplat {
namespace {

// Why there is no CUDA here; empty where there is.
std::string WhyNoCuda() {
#if defined(COSPLAT_HAS_CUDA)
  return cuda::FindDevice() ? "" : "no CUDA device was found";
#else
  return "this program was built without CUDA";
#endif
}

}  // namespace

Device DeviceFromString(const std::string& name, const std::string& field) {
  if (name == "cpu") return Device::kCpu;
  if (name != "auto" && name != "cuda")
    throw Error(field, "'" + name + "' is none of auto, cpu, cuda");
  const std::string reason = WhyNoCuda();
  if (reason.empty()) return Device::kCuda;
  if (name == "cuda") throw Error(field, "cuda: " + reason);
  return Device::kCpu;
}

std::unique_ptr<Rasterizer> MakeRasterizer(Device device) {
  if (device == Device::kCpu) return MakeCpuRasterizer();
#if defined(COSPLAT_HAS_CUDA)
  return cuda::MakeCudaRasterizer(cuda::SumOrder::kFixed);
#else
  throw Error("device", "cuda: " + WhyNoCuda());
#endif
}

SceneRendererMaker SceneRendererOn(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) return cuda::MakeDeviceScene;
#else
  (void)device;  // DeviceFromString gives no other
#endif
  return {};
}

}  // namespace cosplat
