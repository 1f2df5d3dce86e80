// Descriptions of the oneDNN primitives that a network is made of (splat/onnx/onnx_passes.h).
// oneDNN 3 takes what describes a primitive in one call, oneDNN 2 a struct of it first: the only
// place that knows which of them it is.
#pragma once

#include <dnnl.hpp>
#include <vector>

namespace cosplat {

// Engine and attributes that all descriptions of one pass share.
struct OnnxSetting {
  const dnnl::engine& engine;
  const dnnl::primitive_attr& attributes;
};

#if DNNL_VERSION_MAJOR >= 3
using OnnxPooling = dnnl::pooling_forward;
using OnnxPoolingVjp = dnnl::pooling_backward;

template <class Primitive, class... Arguments>
typename Primitive::primitive_desc ForwardDesc(const OnnxSetting& in,
                                               const Arguments&... arguments) {
  return typename Primitive::primitive_desc(in.engine, arguments..., in.attributes);
}
template <class Primitive, class Forward, class... Arguments>
typename Primitive::primitive_desc BackwardDesc(const OnnxSetting& in,
                                                const Forward& forward,
                                                const Arguments&... arguments) {
  return typename Primitive::primitive_desc(in.engine, arguments..., forward, in.attributes);
}
inline dnnl::eltwise_forward::primitive_desc ReluDesc(const OnnxSetting& in,
                                                      dnnl::prop_kind kind,
                                                      const dnnl::memory::desc& data) {
  return ForwardDesc<dnnl::eltwise_forward>(
      in, kind, dnnl::algorithm::eltwise_relu_use_dst_for_bwd, data, data, 0.0f, 0.0f);
}
inline dnnl::eltwise_backward::primitive_desc ReluVjpDesc(
    const OnnxSetting& in,
    const dnnl::eltwise_forward::primitive_desc& forward,
    const dnnl::memory::desc& data) {
  return BackwardDesc<dnnl::eltwise_backward>(
      in, forward, dnnl::algorithm::eltwise_relu_use_dst_for_bwd, data, data, data, 0.0f, 0.0f);
}
inline dnnl::concat::primitive_desc ConcatDesc(const OnnxSetting& in,
                                               const std::vector<dnnl::memory::desc>& parts) {
  return {in.engine, 1, parts, in.attributes};
}
inline dnnl::sum::primitive_desc SumDesc(const OnnxSetting& in, const dnnl::memory::desc& both) {
  return {in.engine, std::vector<float>{1, 1}, {both, both}, in.attributes};
}
#else
using OnnxPooling = dnnl::pooling_v2_forward;
using OnnxPoolingVjp = dnnl::pooling_v2_backward;

template <class Primitive, class... Arguments>
typename Primitive::primitive_desc ForwardDesc(const OnnxSetting& in,
                                               const Arguments&... arguments) {
  return typename Primitive::primitive_desc(
      typename Primitive::desc(arguments...), in.attributes, in.engine);
}
template <class Primitive, class Forward, class... Arguments>
typename Primitive::primitive_desc BackwardDesc(const OnnxSetting& in,
                                                const Forward& forward,
                                                const Arguments&... arguments) {
  return typename Primitive::primitive_desc(
      typename Primitive::desc(arguments...), in.attributes, in.engine, forward);
}
inline dnnl::eltwise_forward::primitive_desc ReluDesc(const OnnxSetting& in,
                                                      dnnl::prop_kind kind,
                                                      const dnnl::memory::desc& data) {
  return ForwardDesc<dnnl::eltwise_forward>(
      in, kind, dnnl::algorithm::eltwise_relu_use_dst_for_bwd, data, 0.0f, 0.0f);
}
inline dnnl::eltwise_backward::primitive_desc ReluVjpDesc(
    const OnnxSetting& in,
    const dnnl::eltwise_forward::primitive_desc& forward,
    const dnnl::memory::desc& data) {
  return BackwardDesc<dnnl::eltwise_backward>(
      in, forward, dnnl::algorithm::eltwise_relu_use_dst_for_bwd, data, data, 0.0f, 0.0f);
}
inline dnnl::concat::primitive_desc ConcatDesc(const OnnxSetting& in,
                                               const std::vector<dnnl::memory::desc>& parts) {
  return {1, parts, in.engine, in.attributes};
}
inline dnnl::sum::primitive_desc SumDesc(const OnnxSetting& in, const dnnl::memory::desc& both) {
  return {std::vector<float>{1, 1}, {both, both}, in.engine, in.attributes};
}
#endif

}  // namespace cosplat
