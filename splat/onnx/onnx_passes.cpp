#include "splat/onnx/onnx_passes.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace cosplat {
namespace {

using dnnl::memory;

constexpr auto kAny = memory::format_tag::any;
constexpr auto kPlanes = memory::format_tag::nchw;

memory::desc DescOf(const memory::dims& dims, memory::format_tag tag) {
  return {dims, memory::data_type::f32, tag};
}
memory::dims Dims(const OnnxPair& pair) { return {pair[0], pair[1]}; }
// oneDNN counts the numbers that are left out.
memory::dims Dilation(const OnnxLayer& layer) {
  return {layer.dilation[0] - 1, layer.dilation[1] - 1};
}
const memory::dims kDense = {0, 0};

}  // namespace

OnnxPasses::OnnxPasses(const dnnl::engine& engine,
                       OnnxGraph& graph,
                       const std::vector<int>& outputs,
                       OnnxPair size,
                       bool keeps)
    : engine_(engine),
      graph_(graph),
      outputs_(outputs),
      size_(size),
      keeps_(keeps),
      forward_(engine),
      backward_(engine) {
  std::string refusal;
  sizes_ = ValueSizes(graph, size, &refusal);  // checked by whoever asks for the pass
  CountReaders();
  image_ = memory(PlainOf(0), engine);
  values_.push_back(image_);
  gradients_.resize(sizes_.size());
  layers_.resize(graph.layers.size());
  for (size_t i = 0; i < layers_.size(); ++i) {
    AddForward(i);
    ReleaseWhatIsRead(i);
  }
  for (const int value : outputs_)
    maps_.push_back(forward_.Converted(values_[size_t(value)], PlainOf(value)));
  forward_.Finish();
  if (keeps) AddBackward();
}

std::vector<FeatureMap> OnnxPasses::Run(const dnnl::stream& stream,
                                        const std::vector<float>& planes) {
  std::memcpy(image_.get_data_handle(), planes.data(), planes.size() * sizeof(float));
  forward_.Execute(stream);
  std::vector<FeatureMap> maps;
  for (size_t i = 0; i < maps_.size(); ++i) {
    const OnnxPair size = sizes_[size_t(outputs_[i])];
    maps.push_back({static_cast<const float*>(maps_[i].get_data_handle()),
                    graph_.ChannelsOf(outputs_[i]),
                    size[0],
                    size[1]});
  }
  return maps;
}

std::vector<float> OnnxPasses::Backward(const dnnl::stream& stream,
                                        const std::vector<std::vector<float>>& d_maps) {
  for (size_t i = 0; i < d_maps_.size(); ++i)
    std::memcpy(d_maps_[i].get_data_handle(), d_maps[i].data(), d_maps[i].size() * sizeof(float));
  backward_.Execute(stream);
  std::vector<float> d_planes(3 * size_t(size_[0]) * size_t(size_[1]));
  if (d_image_)
    std::memcpy(d_planes.data(), d_image_.get_data_handle(), d_planes.size() * sizeof(float));
  return d_planes;
}

memory::dims OnnxPasses::DimsOf(int value) const {
  return {1, graph_.ChannelsOf(value), sizes_[size_t(value)][0], sizes_[size_t(value)][1]};
}
memory::desc OnnxPasses::PlainOf(int value) const { return DescOf(DimsOf(value), kPlanes); }

void OnnxPasses::CountReaders() {
  readers_.resize(sizes_.size());
  ++readers_[0];  // the caller's
  for (const int value : outputs_) ++readers_[size_t(value)];
  for (const OnnxLayer& layer : graph_.layers)
    for (const int value : layer.inputs) ++readers_[size_t(value)];
}

void OnnxPasses::AddForward(size_t i) {
  switch (graph_.layers[i].kind) {
    case OnnxLayer::Kind::kConvolution:
      return AddConvolution(i);
    case OnnxLayer::Kind::kRelu:
      return AddRelu(i);
    case OnnxLayer::Kind::kMaxPool:
      return AddPooling(i);
    case OnnxLayer::Kind::kConcat:
      return AddConcat(i);
  }
}

memory OnnxPasses::ValueMemory(const memory::desc& desc) {
  const auto spare = std::find_if(spare_.begin(), spare_.end(), [&](const memory& one) {
    return one.get_desc().get_size() >= desc.get_size();
  });
  if (spare == spare_.end()) return memory(desc, engine_);
  const memory value(desc, engine_, spare->get_data_handle());
  lent_.push_back(*spare);
  spare_.erase(spare);
  return value;
}

void OnnxPasses::ReleaseWhatIsRead(size_t i) {
  for (const int input : graph_.layers[i].inputs) {
    const memory& value = values_[size_t(input)];
    const bool in_place = value.get_data_handle() == values_[i + 1].get_data_handle();
    if (--readers_[size_t(input)] == 0 && !in_place && !keeps_) spare_.push_back(value);
  }
}

memory::dims OnnxPasses::WeightDims(const OnnxLayer& layer) const {
  const memory::dim read = graph_.ChannelsOf(layer.inputs[0]) / layer.groups;
  if (layer.groups == 1) return {layer.channels, read, layer.kernel[0], layer.kernel[1]};
  return {layer.groups, layer.channels / layer.groups, read, layer.kernel[0], layer.kernel[1]};
}
// The weights are converted here, once.
memory OnnxPasses::WeightsAs(OnnxLayer& layer, const memory::desc& wanted) {
  const auto tag = layer.groups == 1 ? memory::format_tag::oihw : memory::format_tag::goihw;
  const memory plain(DescOf(WeightDims(layer), tag), engine_, layer.weights.data());
  OnnxProgram once(engine_);
  const memory weights = once.Converted(plain, wanted);
  once.Finish();
  once.Execute(dnnl::stream(engine_));
  return weights;
}

void OnnxPasses::AddConvolution(size_t i) {
  OnnxLayer& layer = graph_.layers[i];
  const int result = int(i) + 1;
  const memory::desc bias = DescOf({layer.channels}, memory::format_tag::a);
  const auto desc = ForwardDesc<dnnl::convolution_forward>(forward_.setting(),
                                                           Kind(),
                                                           dnnl::algorithm::convolution_direct,
                                                           DescOf(DimsOf(layer.inputs[0]), kAny),
                                                           DescOf(WeightDims(layer), kAny),
                                                           bias,
                                                           DescOf(DimsOf(result), kAny),
                                                           Dims(layer.stride),
                                                           Dilation(layer),
                                                           Dims(layer.pad_begin),
                                                           Dims(layer.pad_end));
  const memory to = ValueMemory(desc.dst_desc());
  forward_.Add<dnnl::convolution_forward>(
      desc,
      {{DNNL_ARG_SRC, forward_.Converted(values_[size_t(layer.inputs[0])], desc.src_desc())},
       {DNNL_ARG_WEIGHTS, WeightsAs(layer, desc.weights_desc())},
       {DNNL_ARG_BIAS, memory(bias, engine_, layer.bias.data())},
       {DNNL_ARG_DST, to}});
  values_.push_back(to);
  layers_[i].convolution = desc;
}

// In place where nothing reads the value after this.
void OnnxPasses::AddRelu(size_t i) {
  const size_t read = size_t(graph_.layers[i].inputs[0]);
  const memory from = values_[read];
  const memory to = readers_[read] == 1 ? from : ValueMemory(from.get_desc());
  const auto desc = ReluDesc(forward_.setting(), Kind(), from.get_desc());
  forward_.Add<dnnl::eltwise_forward>(desc, {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, to}});
  values_.push_back(to);
  layers_[i].relu = desc;
}

// So that the windows end where the last one does.
memory::dims OnnxPasses::PadEnd(const OnnxLayer& layer, int result) const {
  memory::dims pad;
  for (size_t k = 0; k < 2; ++k)
    pad.push_back((sizes_[size_t(result)][k] - 1) * layer.stride[k] + layer.kernel[k] -
                  sizes_[size_t(layer.inputs[0])][k] - layer.pad_begin[k]);
  return pad;
}

void OnnxPasses::AddPooling(size_t i) {
  const OnnxLayer& layer = graph_.layers[i];
  const int result = int(i) + 1;
  const memory from = values_[size_t(layer.inputs[0])];
  const auto desc = ForwardDesc<OnnxPooling>(forward_.setting(),
                                             Kind(),
                                             dnnl::algorithm::pooling_max,
                                             from.get_desc(),
                                             DescOf(DimsOf(result), kAny),
                                             Dims(layer.stride),
                                             Dims(layer.kernel),
                                             kDense,
                                             Dims(layer.pad_begin),
                                             PadEnd(layer, result));
  const memory to = ValueMemory(desc.dst_desc());
  OnnxArguments arguments{{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, to}};
  if (keeps_)
    arguments[DNNL_ARG_WORKSPACE] = layers_[i].workspace = memory(desc.workspace_desc(), engine_);
  forward_.Add<OnnxPooling>(desc, std::move(arguments));
  values_.push_back(to);
  layers_[i].pooling = desc;
}

void OnnxPasses::AddConcat(size_t i) {
  OnnxArguments arguments;
  std::vector<memory::desc> parts;
  for (const int value : graph_.layers[i].inputs) {
    arguments[DNNL_ARG_MULTIPLE_SRC + int(parts.size())] = values_[size_t(value)];
    parts.push_back(values_[size_t(value)].get_desc());
  }
  const auto desc = ConcatDesc(forward_.setting(), parts);
  const memory to = ValueMemory(desc.dst_desc());
  arguments[DNNL_ARG_DST] = to;
  forward_.Add<dnnl::concat>(desc, std::move(arguments));
  values_.push_back(to);
}

// Each layer adds to the gradients of what it read; when it is reached, that of its result is
// complete.
void OnnxPasses::AddBackward() {
  for (const int value : outputs_) {
    d_maps_.push_back(memory(PlainOf(value), engine_));
    backward_.AddTo(gradients_[size_t(value)], d_maps_.back());
  }
  for (size_t i = layers_.size(); i-- > 0;)
    if (gradients_[i + 1]) AddBackward(i);
  if (gradients_[0]) d_image_ = backward_.Converted(gradients_[0], PlainOf(0));
  backward_.Finish();
}

void OnnxPasses::AddBackward(size_t i) {
  switch (graph_.layers[i].kind) {
    case OnnxLayer::Kind::kConvolution:
      return AddConvolutionVjp(i);
    case OnnxLayer::Kind::kRelu:
      return AddReluVjp(i);
    case OnnxLayer::Kind::kMaxPool:
      return AddPoolingVjp(i);
    case OnnxLayer::Kind::kConcat:
      return AddConcatVjp(i);
  }
}

void OnnxPasses::AddConvolutionVjp(size_t i) {
  OnnxLayer& layer = graph_.layers[i];
  const auto desc =
      BackwardDesc<dnnl::convolution_backward_data>(backward_.setting(),
                                                    layers_[i].convolution,
                                                    dnnl::algorithm::convolution_direct,
                                                    DescOf(DimsOf(layer.inputs[0]), kAny),
                                                    DescOf(WeightDims(layer), kAny),
                                                    DescOf(DimsOf(int(i) + 1), kAny),
                                                    Dims(layer.stride),
                                                    Dilation(layer),
                                                    Dims(layer.pad_begin),
                                                    Dims(layer.pad_end));
  const memory d_input(desc.diff_src_desc(), engine_);
  backward_.Add<dnnl::convolution_backward_data>(
      desc,
      {{DNNL_ARG_DIFF_DST, backward_.Converted(gradients_[i + 1], desc.diff_dst_desc())},
       {DNNL_ARG_WEIGHTS, WeightsAs(layer, desc.weights_desc())},
       {DNNL_ARG_DIFF_SRC, d_input}});
  backward_.AddTo(GradientOfInput(i), d_input);
}

void OnnxPasses::AddReluVjp(size_t i) {
  const memory result = values_[i + 1];
  const auto desc = ReluVjpDesc(backward_.setting(), layers_[i].relu, result.get_desc());
  const memory d_input(desc.diff_src_desc(), engine_);
  backward_.Add<dnnl::eltwise_backward>(
      desc,
      {{DNNL_ARG_DST, result},
       {DNNL_ARG_DIFF_DST, backward_.Converted(gradients_[i + 1], desc.diff_dst_desc())},
       {DNNL_ARG_DIFF_SRC, d_input}});
  backward_.AddTo(GradientOfInput(i), d_input);
}

void OnnxPasses::AddPoolingVjp(size_t i) {
  const OnnxLayer& layer = graph_.layers[i];
  const auto desc = BackwardDesc<OnnxPoolingVjp>(backward_.setting(),
                                                 layers_[i].pooling,
                                                 dnnl::algorithm::pooling_max,
                                                 values_[size_t(layer.inputs[0])].get_desc(),
                                                 DescOf(DimsOf(int(i) + 1), kAny),
                                                 Dims(layer.stride),
                                                 Dims(layer.kernel),
                                                 kDense,
                                                 Dims(layer.pad_begin),
                                                 PadEnd(layer, int(i) + 1));
  const memory d_input(desc.diff_src_desc(), engine_);
  backward_.Add<OnnxPoolingVjp>(
      desc,
      {{DNNL_ARG_WORKSPACE, layers_[i].workspace},
       {DNNL_ARG_DIFF_DST, backward_.Converted(gradients_[i + 1], desc.diff_dst_desc())},
       {DNNL_ARG_DIFF_SRC, d_input}});
  backward_.AddTo(GradientOfInput(i), d_input);
}

// Planes can be divided after any channel, which oneDNN's blocks of channels cannot.
void OnnxPasses::AddConcatVjp(size_t i) {
  const memory planes = backward_.Converted(gradients_[i + 1], PlainOf(int(i) + 1));
  memory::dim first = 0;
  for (const int value : graph_.layers[i].inputs) {
    const memory::desc part = planes.get_desc().submemory_desc(DimsOf(value), {0, first, 0, 0});
    backward_.AddTo(gradients_[size_t(value)],
                    backward_.Copied(planes, part, values_[size_t(value)].get_desc()));
    first += graph_.ChannelsOf(value);
  }
}

}  // namespace cosplat
