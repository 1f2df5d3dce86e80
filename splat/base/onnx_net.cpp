#include "splat/base/onnx_net.h"

#include <algorithm>
#include <exception>
#include <opencv2/core/utility.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/dnn/all_layers.hpp>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/image_io.h"

namespace cosplat {
namespace {

// Recognition networks take 224 px, and mostly accept less.
constexpr int kMaxMinSide = 256;

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string ReasonOf(const std::exception& error) {
  const auto* opencv = dynamic_cast<const cv::Exception*>(&error);
  return FirstLine(opencv ? opencv->err : error.what());
}

cv::dnn::Net ReadNet(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  try {
    return cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  } catch (const std::exception& error) {
    throw Error(path, "cannot be read as an ONNX network: " + ReasonOf(error));
  }
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// OpenCV infers a size of 1 for a kernel larger than its input, and then interprets negative
// differences as memory sizes.
bool KernelFits(const cv::dnn::Layer& layer, const std::vector<cv::dnn::MatShape>& inputs) {
  const auto* conv = dynamic_cast<const cv::dnn::ConvolutionLayer*>(&layer);
  if (!conv) return true;
  for (size_t k = 0; k < conv->kernel_size.size(); ++k) {
    const size_t reach = (conv->kernel_size[k] - 1) * conv->dilations[k] + 1;
    if (size_t(inputs.at(0).at(2 + k)) + conv->pads_begin[k] + conv->pads_end[k] < reach)
      return false;
  }
  return true;
}

bool HasSomething(const std::vector<cv::dnn::MatShape>& shapes) {
  return std::all_of(shapes.begin(), shapes.end(), [](const cv::dnn::MatShape& shape) {
    return std::all_of(shape.begin(), shape.end(), [](int extent) { return extent > 0; });
  });
}

// [3, H, W] in [-1, 1].
std::vector<float> ToPlanes(const Image8& image) {
  std::vector<float> planes(3 * image.pixels());
  for (size_t i = 0; i < image.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c)
      planes[c * image.pixels() + i] = float(image.data[3 * i + c]) / 127.5f - 1;
  return planes;
}

}  // namespace

struct OnnxNet::Impl {
  cv::dnn::Net net;
  std::vector<std::string> outputs;
  std::vector<cv::Mat> maps;

  // Returns why the net rejects the image; empty if it accepts it.
  std::string Forward(const Image8& image) {
    std::vector<float> planes = ToPlanes(image);
    const int shape[] = {1, 3, image.height, image.width};
    try {
      net.setInput(cv::Mat(4, shape, CV_32F, planes.data()));
      maps.clear();
      net.forward(maps, outputs);
      return "";
    } catch (const std::exception& error) {
      return ReasonOf(error);
    }
  }

  // The same for a square image that may be much too small.
  std::string Try(int side) {
    std::vector<int> layers;
    std::vector<std::vector<cv::dnn::MatShape>> inputs, results;
    try {
      net.getLayersShapes(cv::dnn::MatShape{1, 3, side, side}, layers, inputs, results);
      for (size_t i = 0; i < layers.size(); ++i)
        if (!KernelFits(*net.getLayer(layers[i]), inputs[i]) || !HasSomething(results[i]))
          return "a layer has nothing left";
    } catch (const std::exception& error) {
      return ReasonOf(error);
    }
    return Forward(Image8(side, side, 3));
  }
};

OnnxNet::OnnxNet(const std::string& path, const std::vector<std::string>& outputs)
    : path_(path), impl_(std::make_unique<Impl>()) {
  QuietOpenCv();
  cv::setNumThreads(1);
  impl_->net = ReadNet(path);
  impl_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  impl_->outputs = outputs;
  const std::vector<std::string> known = impl_->net.getUnconnectedOutLayersNames();
  for (const std::string& name : outputs)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(path, "output " + name, "is missing; the outputs are " + Listed(known));
  std::string refusal;
  do {
    if (++least_side_ > kMaxMinSide) throw Error(path, "does not accept an RGB image: " + refusal);
    refusal = impl_->Try(least_side_);
  } while (!refusal.empty());
  for (size_t i = 0; i < outputs.size(); ++i) {
    const cv::Mat& map = impl_->maps[i];
    if (map.dims != 4)
      throw Error(path,
                  "output " + outputs[i],
                  "has " + std::to_string(map.dims) + " dimensions, expected [1, C, h, w]");
    channels_.push_back(map.size[1]);
  }
}

OnnxNet::~OnnxNet() = default;
OnnxNet::OnnxNet(OnnxNet&&) noexcept = default;

std::vector<FeatureMap> OnnxNet::Run(const Image8& image) {
  if (image.channels != 3 || image.width < least_side_ || image.height < least_side_)
    throw Error(path_,
                "takes RGB images of at least " + SizeText(least_side_, least_side_) + ", not " +
                    SizeText(image.width, image.height) + "x" + std::to_string(image.channels));
  const std::string refusal = impl_->Forward(image);
  if (!refusal.empty()) throw Error(path_, "cannot be run on an image: " + refusal);
  std::vector<FeatureMap> maps;
  for (const cv::Mat& map : impl_->maps)
    maps.push_back({map.ptr<float>(), map.size[1], map.size[2], map.size[3]});
  return maps;
}

}  // namespace cosplat
