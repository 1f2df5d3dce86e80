// The browser's build has no oneDNN: networks are refused there.
#include "splat/base/error.h"
#include "splat/onnx/onnx_net.h"

namespace cosplat {

struct OnnxNet::Impl {};
OnnxNet::OnnxNet(const std::string& path, const std::vector<std::string>&) {
  throw Error(path, "cannot be run in a browser");
}
OnnxNet::~OnnxNet() = default;
OnnxNet::OnnxNet(OnnxNet&&) noexcept = default;
std::vector<FeatureMap> OnnxNet::Run(const std::vector<float>&, int, int, bool) { return {}; }
std::vector<float> OnnxNet::Backward(const std::vector<std::vector<float>>&) { return {}; }

}  // namespace cosplat
