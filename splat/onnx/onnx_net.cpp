#include "splat/onnx/onnx_net.h"

#include <omp.h>

#include <utility>

#include "splat/base/error.h"
#include "splat/base/image.h"
#include "splat/onnx/onnx_passes.h"

namespace cosplat {
namespace {

// Recognition networks take 224 px, and mostly accept less.
constexpr int kMaxMinSide = 256;

// oneDNN promises the same bits only for the same number of threads.
class OneThread {
 public:
  OneThread() { omp_set_num_threads(1); }
  ~OneThread() { omp_set_num_threads(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  const int before_ = omp_get_max_threads();
};

std::string Listed(const OnnxGraph& graph) {
  std::string text;
  for (const auto& [name, value] : graph.outputs) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

struct OnnxNet::Impl {
  std::string path;
  OnnxGraph graph;
  std::vector<int> outputs;  // values
  dnnl::engine engine{dnnl::engine::kind::cpu, 0};
  dnnl::stream stream{engine};
  std::unique_ptr<OnnxPasses> passes;
};

OnnxNet::OnnxNet(const std::string& path, const std::vector<std::string>& outputs)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->graph = ReadOnnx(path);
  const OnnxGraph& graph = impl_->graph;
  for (const std::string& name : outputs) {
    const auto output = graph.outputs.find(name);
    if (output == graph.outputs.end())
      throw Error(path, "output " + name, "is missing; the outputs are " + Listed(graph));
    impl_->outputs.push_back(output->second);
    channels_.push_back(graph.ChannelsOf(output->second));
  }
  std::string refusal;
  do {
    if (++min_side_ > kMaxMinSide) throw Error(path, "does not accept an RGB image: " + refusal);
  } while (ValueSizes(graph, {min_side_, min_side_}, &refusal).empty());
}

OnnxNet::~OnnxNet() = default;
OnnxNet::OnnxNet(OnnxNet&&) noexcept = default;

std::vector<FeatureMap> OnnxNet::Run(const std::vector<float>& planes,
                                     int width,
                                     int height,
                                     bool keeps) {
  if (width < min_side_ || height < min_side_)
    throw Error(impl_->path,
                "takes images of at least " + SizeText(min_side_, min_side_) + ", not " +
                    SizeText(width, height));
  const OneThread one_thread;
  try {
    std::unique_ptr<OnnxPasses>& passes = impl_->passes;
    const OnnxPair size{height, width};
    if (!passes || !passes->Are(size, keeps)) {
      passes = nullptr;  // its memory is free for the next
      passes =
          std::make_unique<OnnxPasses>(impl_->engine, impl_->graph, impl_->outputs, size, keeps);
    }
    return passes->Run(impl_->stream, planes);
  } catch (const dnnl::error& error) {
    throw Error(impl_->path, std::string("cannot be run on an image: ") + error.what());
  }
}

std::vector<float> OnnxNet::Backward(const std::vector<std::vector<float>>& d_maps) {
  const OneThread one_thread;
  try {
    return impl_->passes->Backward(impl_->stream, d_maps);
  } catch (const dnnl::error& error) {
    throw Error(impl_->path, std::string("has no gradient: ") + error.what());
  }
}

}  // namespace cosplat
