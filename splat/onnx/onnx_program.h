// A list of oneDNN primitives, with what they work on: the forward or the backward pass of a
// network (splat/onnx/onnx_passes.h).
#pragma once

#include <algorithm>
#include <dnnl.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "splat/onnx/onnx_primitives.h"

namespace cosplat {

using OnnxArguments = std::unordered_map<int, dnnl::memory>;

// Is executed in order. The primitives share one scratchpad: oneDNN's own would be shared with the
// networks of other threads.
class OnnxProgram {
 public:
  explicit OnnxProgram(const dnnl::engine& engine) : engine_(engine) {
    attributes_.set_scratchpad_mode(dnnl::scratchpad_mode::user);
  }
  OnnxSetting setting() const { return {engine_, attributes_}; }

  template <class Primitive>
  void Add(const typename Primitive::primitive_desc& desc, OnnxArguments arguments) {
    arguments[DNNL_ARG_SCRATCHPAD] =
        dnnl::memory(desc.scratchpad_desc(), engine_, DNNL_MEMORY_NONE);
    scratch_bytes_ = std::max(scratch_bytes_, desc.scratchpad_desc().get_size());
    steps_.push_back({Primitive(desc), std::move(arguments)});
  }
  dnnl::memory Copied(const dnnl::memory& from,
                      const dnnl::memory::desc& part,
                      const dnnl::memory::desc& wanted) {
    const dnnl::memory to(wanted, engine_), of_part(part, engine_, from.get_data_handle());
    Add<dnnl::reorder>({engine_, part, engine_, wanted, attributes_},
                       {{DNNL_ARG_FROM, of_part}, {DNNL_ARG_TO, to}});
    return to;
  }
  // `from` itself if it is as wanted.
  dnnl::memory Converted(const dnnl::memory& from, const dnnl::memory::desc& wanted) {
    return from.get_desc() == wanted ? from : Copied(from, from.get_desc(), wanted);
  }
  // Adds `more` to the sum, which is empty at first.
  void AddTo(dnnl::memory& sum, const dnnl::memory& more) {
    if (!sum) {
      sum = more;
      return;
    }
    const dnnl::memory::desc desc = sum.get_desc();
    Add<dnnl::sum>(SumDesc(setting(), desc),
                   {{DNNL_ARG_MULTIPLE_SRC, sum},
                    {DNNL_ARG_MULTIPLE_SRC + 1, Converted(more, desc)},
                    {DNNL_ARG_DST, sum}});
  }
  void Finish() {
    const dnnl::memory::dim bytes = dnnl::memory::dim(scratch_bytes_);
    scratch_ =
        dnnl::memory({{bytes}, dnnl::memory::data_type::u8, dnnl::memory::format_tag::a}, engine_);
    for (Step& step : steps_)
      step.arguments[DNNL_ARG_SCRATCHPAD].set_data_handle(scratch_.get_data_handle());
  }
  void Execute(const dnnl::stream& stream) const {
    for (const Step& step : steps_) step.primitive.execute(stream, step.arguments);
  }

 private:
  struct Step {
    dnnl::primitive primitive;
    OnnxArguments arguments;
  };
  const dnnl::engine& engine_;
  dnnl::primitive_attr attributes_;
  std::vector<Step> steps_;
  size_t scratch_bytes_ = 0;
  dnnl::memory scratch_;
};

}  // namespace cosplat
