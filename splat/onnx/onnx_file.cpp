#include "splat/onnx/onnx_file.h"

#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

// What is larger is an error in the file: LPIPS's networks have up to 512 channels, and kernels of
// up to 11x11.
constexpr int kMaxExtent = 1 << 15;  // of arrays of weights, and of channels
constexpr int kMaxWindow = 64;       // of kernels, strides, dilations and paddings

struct Constant {
  std::vector<int64_t> shape;
  std::vector<float> values;
};

// How many numbers a kernel spans.
int ReachOf(const OnnxLayer& layer, int k) { return (layer.kernel[k] - 1) * layer.dilation[k] + 1; }

// A name from the file, for messages of one line.
std::string Printable(std::string name) {
  for (char& c : name)
    if (std::iscntrl(static_cast<unsigned char>(c))) c = '?';
  return name;
}

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  OnnxGraph Read() {
    const std::vector<char> bytes = ReadFile(path_);
    onnx::ModelProto model;
    if (!model.ParseFromArray(bytes.data(), int(bytes.size())) || model.graph().node_size() == 0)
      throw Error(path_, "cannot be read as an ONNX network");
    const onnx::GraphProto& graph = model.graph();
    for (const onnx::TensorProto& tensor : graph.initializer())
      constants_[tensor.name()] = Values(tensor, tensor.name());
    AddImage(graph);
    for (const onnx::NodeProto& node : graph.node()) AddNode(node);
    for (const onnx::ValueInfoProto& output : graph.output())
      if (values_.count(output.name()))
        graph_.outputs[Printable(output.name())] = values_[output.name()];
    return std::move(graph_);
  }

 private:
  Constant Values(const onnx::TensorProto& tensor, const std::string& of) const {
    const std::string name = Printable(of);
    if (tensor.data_type() != onnx::TensorProto::FLOAT)
      throw Error(path_, name, "is not of type float");
    if (tensor.data_location() == onnx::TensorProto::EXTERNAL)
      throw Error(path_, name, "is stored in another file");
    Constant constant{{tensor.dims().begin(), tensor.dims().end()}, {}};
    constant.values.assign(tensor.float_data().begin(), tensor.float_data().end());
    if (tensor.has_raw_data()) {
      constant.values.resize(tensor.raw_data().size() / sizeof(float));
      std::memcpy(
          constant.values.data(), tensor.raw_data().data(), constant.values.size() * sizeof(float));
    }
    uint64_t count = 1;
    for (const int64_t extent : constant.shape) {
      if (extent < 1 || extent > kMaxExtent || count > uint64_t(1) << 32)
        throw Error(path_, name, "has an extent of " + std::to_string(extent));
      count *= uint64_t(extent);
    }
    if (count != constant.values.size())
      throw Error(path_,
                  name,
                  "has " + std::to_string(constant.values.size()) + " numbers, its shape " +
                      std::to_string(count));
    return constant;
  }

  // The file's only input that is not a constant.
  void AddImage(const onnx::GraphProto& graph) {
    std::vector<const onnx::ValueInfoProto*> inputs;
    for (const onnx::ValueInfoProto& input : graph.input())
      if (!constants_.count(input.name())) inputs.push_back(&input);
    if (inputs.size() != 1)
      throw Error(path_, "has " + std::to_string(inputs.size()) + " inputs, expected an RGB image");
    const onnx::TensorShapeProto& shape = inputs[0]->type().tensor_type().shape();
    if (shape.dim_size() != 4 ||
        (shape.dim(1).has_dim_value() && shape.dim(1).dim_value() != graph_.ChannelsOf(0)))
      throw Error(
          path_, "input " + Printable(inputs[0]->name()), "is not an RGB image [1, 3, H, W]");
    values_[inputs[0]->name()] = 0;
  }

  void AddNode(const onnx::NodeProto& node) {
    if (node.output_size() == 0 || (node.op_type() != "Constant" && node.input_size() == 0))
      throw Error(path_, NameOf(node), "has no inputs or no outputs");
    const std::string& op = node.op_type();
    if (op == "Constant") {
      constants_[node.output(0)] = Values(AttributeOf(node, "value").t(), node.output(0));
    } else if (op == "Identity" || op == "Dropout") {  // Dropout does nothing after training
      if (constants_.count(node.input(0)))
        constants_[node.output(0)] = constants_[node.input(0)];
      else
        values_[node.output(0)] = ValueOf(node, 0);
    } else if (op == "Conv") {
      AddConvolution(node);
    } else if (op == "Add" || op == "Sub" || op == "Mul" || op == "Div") {
      AddScaling(node);
    } else if (op == "MaxPool") {
      AddPooling(node);
    } else if (op == "Relu") {
      OnnxLayer layer = LayerOf(node, OnnxLayer::Kind::kRelu);
      layer.channels = graph_.ChannelsOf(layer.inputs[0]);
      Add(node, std::move(layer));
    } else if (op == "Concat") {
      AddConcat(node);
    } else {
      throw Error(path_,
                  NameOf(node),
                  "is not among the layers that are known: Conv, Relu, MaxPool, Concat, Add, Sub, "
                  "Mul and Div by constants");
    }
  }

  void AddConvolution(const onnx::NodeProto& node) {
    OnnxLayer layer = LayerOf(node, OnnxLayer::Kind::kConvolution);
    const Constant weights = ConstantOf(node, 1);
    if (weights.shape.size() != 4) throw Error(path_, NameOf(node), "is not two-dimensional");
    layer.channels = int(weights.shape[0]);
    layer.kernel = {int(weights.shape[2]), int(weights.shape[3])};
    ReadWindow(node, layer);
    layer.groups = Number(node, "group", 1);
    const int read = graph_.ChannelsOf(layer.inputs[0]);
    if (weights.shape[1] * layer.groups != read || layer.channels % layer.groups != 0)
      throw Error(path_, NameOf(node), "does not fit the " + std::to_string(read) + " channels");
    layer.weights = weights.values;
    layer.bias.assign(size_t(layer.channels), 0.0f);
    if (node.input_size() > 2) layer.bias = ConstantOf(node, 2).values;
    if (int(layer.bias.size()) != layer.channels)
      throw Error(path_, NameOf(node), "has not a bias per channel");
    Add(node, std::move(layer));
  }

  // x + c, x - c, c - x, c x, x / c: scale x + shift.
  void AddScaling(const onnx::NodeProto& node) {
    const bool first = node.input_size() == 2 && constants_.count(node.input(0));
    if (node.input_size() != 2 || first == (constants_.count(node.input(1)) != 0) ||
        (first && node.op_type() == "Div"))
      throw Error(path_, NameOf(node), "is supported only of a value and a constant");
    OnnxLayer layer = LayerOf(node, OnnxLayer::Kind::kConvolution, first ? 1 : 0);
    layer.channels = layer.groups = graph_.ChannelsOf(layer.inputs[0]);
    const Constant constant = ConstantOf(node, first ? 0 : 1);
    const size_t count = constant.values.size();
    // [C, 1, 1], or that after a 1, or one number.
    const bool per_channel = count == size_t(layer.channels) && constant.shape.size() >= 3 &&
                             constant.shape[constant.shape.size() - 3] == layer.channels;
    if (count != 1 && !per_channel)
      throw Error(path_, NameOf(node), "has not a number per channel");
    for (int c = 0; c < layer.channels; ++c) {
      const float value = constant.values[count == 1 ? 0 : size_t(c)];
      float scale = 1, shift = 0;
      if (node.op_type() == "Add") shift = value;
      if (node.op_type() == "Sub") shift = first ? value : -value;
      if (node.op_type() == "Sub" && first) scale = -1;
      if (node.op_type() == "Mul") scale = value;
      if (node.op_type() == "Div") scale = 1 / value;
      layer.weights.push_back(scale);
      layer.bias.push_back(shift);
    }
    Add(node, std::move(layer));
  }

  void AddPooling(const onnx::NodeProto& node) {
    OnnxLayer layer = LayerOf(node, OnnxLayer::Kind::kMaxPool);
    layer.channels = graph_.ChannelsOf(layer.inputs[0]);
    layer.kernel = Pair(node, "kernel_shape", 0, 0);
    ReadWindow(node, layer);
    layer.ceil = Number(node, "ceil_mode", 0) != 0;
    if (layer.dilation != OnnxPair{1, 1}) throw Error(path_, NameOf(node), "is dilated");
    Add(node, std::move(layer));
  }

  void AddConcat(const onnx::NodeProto& node) {
    OnnxLayer layer = LayerOf(node, OnnxLayer::Kind::kConcat);
    const int axis = int(AttributeOf(node, "axis").i());
    if (axis != 1 && axis != -3) throw Error(path_, NameOf(node), "does not join channels");
    for (int i = 1; i < node.input_size(); ++i) layer.inputs.push_back(ValueOf(node, i));
    for (const int input : layer.inputs) layer.channels += graph_.ChannelsOf(input);
    Add(node, std::move(layer));
  }

  void ReadWindow(const onnx::NodeProto& node, OnnxLayer& layer) const {
    const std::string padding = AttributeOf(node, "auto_pad").s();
    if (!padding.empty() && padding != "NOTSET") throw Error(path_, NameOf(node), "has auto_pad");
    layer.stride = Pair(node, "strides", 0, 1);
    layer.dilation = Pair(node, "dilations", 0, 1);
    layer.pad_begin = Pair(node, "pads", 0, 0);
    layer.pad_end = Pair(node, "pads", 2, 0);
    for (int k = 0; k < 2; ++k) {
      if (layer.kernel[k] < 1 || layer.kernel[k] > kMaxWindow || layer.stride[k] < 1 ||
          layer.dilation[k] < 1)
        throw Error(path_, NameOf(node), "has an impossible kernel, stride or dilation");
      if (std::max(layer.pad_begin[k], layer.pad_end[k]) >= ReachOf(layer, k))
        throw Error(path_, NameOf(node), "has padding as wide as its kernel");
    }
  }

  static const onnx::AttributeProto& AttributeOf(const onnx::NodeProto& node, const char* name) {
    for (const onnx::AttributeProto& attribute : node.attribute())
      if (attribute.name() == name) return attribute;
    return onnx::AttributeProto::default_instance();
  }
  int Checked(const onnx::NodeProto& node, int64_t value, int max) const {
    if (value < 0 || value > max)
      throw Error(path_, NameOf(node), "contains the number " + std::to_string(value));
    return int(value);
  }
  int Number(const onnx::NodeProto& node, const char* name, int otherwise) const {
    const onnx::AttributeProto& attribute = AttributeOf(node, name);
    return attribute.has_i() ? Checked(node, attribute.i(), kMaxExtent) : otherwise;
  }
  // Two numbers of an attribute, from `first` on.
  OnnxPair Pair(const onnx::NodeProto& node, const char* name, int first, int otherwise) const {
    const onnx::AttributeProto& attribute = AttributeOf(node, name);
    if (attribute.ints_size() == 0) return {otherwise, otherwise};
    if (attribute.ints_size() < first + 2)
      throw Error(path_, NameOf(node), std::string(name) + " is not of two dimensions");
    return {Checked(node, attribute.ints(first), kMaxWindow),
            Checked(node, attribute.ints(first + 1), kMaxWindow)};
  }

  static std::string NameOf(const onnx::NodeProto& node) {
    std::string name = node.name();
    if (name.empty() && node.output_size() > 0) name = node.output(0);
    return Printable("layer " + name + " (" + node.op_type() + ")");
  }
  int ValueOf(const onnx::NodeProto& node, int input) const {
    const auto value = values_.find(node.input(input));
    if (value == values_.end())
      throw Error(path_,
                  NameOf(node),
                  "reads " + Printable(node.input(input)) + ", which no layer before it writes");
    return value->second;
  }
  Constant ConstantOf(const onnx::NodeProto& node, int input) const {
    const auto constant =
        input < node.input_size() ? constants_.find(node.input(input)) : constants_.end();
    if (constant == constants_.end())
      throw Error(path_, NameOf(node), "has weights that are not constants");
    return constant->second;
  }

  OnnxLayer LayerOf(const onnx::NodeProto& node, OnnxLayer::Kind kind, int input = 0) const {
    OnnxLayer layer;
    layer.kind = kind;
    layer.name = NameOf(node);
    layer.inputs = {ValueOf(node, input)};
    return layer;
  }
  void Add(const onnx::NodeProto& node, OnnxLayer layer) {
    if (layer.channels < 1 || layer.channels > kMaxExtent)
      throw Error(path_, layer.name, "has " + std::to_string(layer.channels) + " channels");
    graph_.layers.push_back(std::move(layer));
    values_[node.output(0)] = int(graph_.layers.size());
  }

  const std::string path_;
  OnnxGraph graph_;
  std::map<std::string, Constant> constants_;
  std::map<std::string, int> values_;
};

// The size of one axis after the layer; 0 or less: nothing is left.
int SizeAfter(const OnnxLayer& layer, int k, int size) {
  const int room = size + layer.pad_begin[k] + layer.pad_end[k] - ReachOf(layer, k);
  if (room < 0) return 0;
  if (!layer.ceil) return room / layer.stride[k] + 1;
  const int steps = (room + layer.stride[k] - 1) / layer.stride[k];
  // A window begins inside the image or the padding before it.
  return steps * layer.stride[k] < size + layer.pad_begin[k] ? steps + 1 : steps;
}

}  // namespace

OnnxGraph ReadOnnx(const std::string& path) { return Reader(path).Read(); }

std::vector<OnnxPair> ValueSizes(const OnnxGraph& graph, OnnxPair image, std::string* refusal) {
  std::vector<OnnxPair> sizes{image};
  for (const OnnxLayer& layer : graph.layers) {
    OnnxPair size = sizes[size_t(layer.inputs[0])];
    for (const int input : layer.inputs)
      if (sizes[size_t(input)] != size) {
        *refusal = layer.name + " joins maps of different sizes";
        return {};
      }
    if (layer.kind == OnnxLayer::Kind::kConvolution || layer.kind == OnnxLayer::Kind::kMaxPool)
      for (int k = 0; k < 2; ++k) size[k] = SizeAfter(layer, k, size[k]);
    if (size[0] <= 0 || size[1] <= 0) {
      *refusal = layer.name + " has nothing left";
      return {};
    }
    sizes.push_back(size);
  }
  return sizes;
}

}  // namespace cosplat
