// The passes of a network (splat/onnx/onnx_file.h) over images of one size, by oneDNN.
#pragma once

#include <dnnl.hpp>
#include <vector>

#include "splat/onnx/onnx_file.h"
#include "splat/onnx/onnx_net.h"
#include "splat/onnx/onnx_program.h"

namespace cosplat {

// oneDNN chooses how arrays are stored in blocks of channels; images, outputs and their gradients
// are planes.
class OnnxPasses {
 public:
  // Keeps references to all but `size`, which every layer must accept (ValueSizes). keeps: what
  // Backward needs.
  OnnxPasses(const dnnl::engine& engine,
             OnnxGraph& graph,
             const std::vector<int>& outputs,
             OnnxPair size,
             bool keeps);

  bool Are(OnnxPair size, bool keeps) const { return size == size_ && keeps == keeps_; }
  // As in OnnxNet.
  std::vector<FeatureMap> Run(const dnnl::stream& stream, const std::vector<float>& planes);
  std::vector<float> Backward(const dnnl::stream& stream,
                              const std::vector<std::vector<float>>& d_maps);

 private:
  // What a layer's backward pass needs of its forward pass.
  struct Kept {
    dnnl::convolution_forward::primitive_desc convolution;
    dnnl::eltwise_forward::primitive_desc relu;
    OnnxPooling::primitive_desc pooling;
    dnnl::memory workspace;  // of pooling: where each maximum was
  };

  dnnl::memory::dims DimsOf(int value) const;
  dnnl::memory::desc PlainOf(int value) const;
  dnnl::prop_kind Kind() const {
    return keeps_ ? dnnl::prop_kind::forward_training : dnnl::prop_kind::forward_inference;
  }
  dnnl::memory::dims WeightDims(const OnnxLayer& layer) const;
  dnnl::memory WeightsAs(OnnxLayer& layer, const dnnl::memory::desc& wanted);
  dnnl::memory::dims PadEnd(const OnnxLayer& layer, int result) const;
  dnnl::memory& GradientOfInput(size_t i) { return gradients_[size_t(graph_.layers[i].inputs[0])]; }
  // Memory for a value; where nothing is kept, that of one that no layer reads any more.
  dnnl::memory ValueMemory(const dnnl::memory::desc& desc);
  void ReleaseWhatIsRead(size_t i);
  // Layer i's part of the forward pass, then those of the backward pass.
  void CountReaders();
  void AddForward(size_t i);
  void AddConvolution(size_t i);
  void AddRelu(size_t i);
  void AddPooling(size_t i);
  void AddConcat(size_t i);
  void AddBackward();
  void AddBackward(size_t i);
  void AddConvolutionVjp(size_t i);
  void AddReluVjp(size_t i);
  void AddPoolingVjp(size_t i);
  void AddConcatVjp(size_t i);

  const dnnl::engine& engine_;
  OnnxGraph& graph_;
  const std::vector<int>& outputs_;  // values
  const OnnxPair size_;
  const bool keeps_;
  std::vector<OnnxPair> sizes_;  // of each value
  std::vector<int> readers_;     // likewise: how many there still are
  std::vector<dnnl::memory> spare_, lent_;
  std::vector<dnnl::memory> values_, gradients_;
  std::vector<Kept> layers_;
  dnnl::memory image_, d_image_;
  std::vector<dnnl::memory> maps_, d_maps_;  // of the outputs
  OnnxProgram forward_, backward_;
};

}  // namespace cosplat
