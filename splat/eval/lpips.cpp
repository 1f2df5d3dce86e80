#include "splat/eval/lpips.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <sstream>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

constexpr const char* kBackbone = "_backbone.onnx";

// Keeps pixels with all-zero channels finite (the value of the reference implementation).
constexpr float kTinySquare = 1e-20f;

std::string FindNet(const std::string& folder) {
  std::vector<std::string> nets;
  std::error_code ignored;  // if there is no such folder, no net is found
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(kBackbone)) nets.push_back(name);
  }
  std::sort(nets.begin(), nets.end());
  if (nets.empty()) throw Error(folder, std::string("contains no NET") + kBackbone);
  if (nets.size() > 1)
    throw Error(folder, "holds " + nets[0] + " and " + nets[1] + ", expected one net");
  return nets[0].substr(0, nets[0].size() - std::string(kBackbone).size());
}

std::vector<std::string> ReadTaps(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  std::istringstream words(std::string(bytes.begin(), bytes.end()));
  std::vector<std::string> taps;
  for (std::string name; words >> name;) taps.push_back(name);
  if (taps.empty()) throw Error(path, "lists no outputs of the network");
  return taps;
}

std::vector<std::vector<float>> ReadWeights(const std::string& path,
                                            const std::vector<std::string>& taps,
                                            const std::vector<int>& channels) {
  const Npz npz = Npz::Read(path);
  std::vector<std::vector<float>> weights;
  for (size_t i = 0; i < channels.size(); ++i) {
    const std::string name = "lin" + std::to_string(i);
    const NpyArray& array = npz.Get(name);
    if (array.size() != size_t(channels[i]))
      throw Error(path,
                  name,
                  "has " + std::to_string(array.size()) + " weights, the net's output " + taps[i] +
                      " has " + std::to_string(channels[i]) + " channels");
    for (size_t c = 0; c < array.size(); ++c)
      if (!std::isfinite(array.values[c]))
        throw Error(path, name + "[" + std::to_string(c) + "]", "is not a finite number");
    weights.emplace_back(array.values.begin(), array.values.end());
  }
  const std::string next = "lin" + std::to_string(channels.size());
  if (npz.Has(next))
    throw Error(
        path, next, "has no matching tap: the number of taps is " + std::to_string(taps.size()));
  return weights;
}

// Factors that normalise the channels of each pixel of row `y` to length 1.
std::vector<float> RowNorms(const FeatureMap& map, int y) {
  const float* row = map.data + size_t(y) * map.width;
  std::vector<float> norms(size_t(map.width), kTinySquare);
  const size_t plane = size_t(map.height) * map.width;
  for (int c = 0; c < map.channels; ++c)
    for (int x = 0; x < map.width; ++x) norms[x] += row[c * plane + x] * row[c * plane + x];
  for (float& norm : norms) norm = 1 / std::sqrt(norm);
  return norms;
}

// Sum over the pixels of row `y` of w (u - v)^2, u = a / sqrt(|a|^2 + tiny), v likewise of b; over
// the channels.
double RowDistance(const FeatureMap& a,
                   const FeatureMap& b,
                   const std::vector<float>& weights,
                   int y) {
  const float* row_a = a.data + size_t(y) * a.width;
  const float* row_b = b.data + size_t(y) * b.width;
  const std::vector<float> norms_a = RowNorms(a, y), norms_b = RowNorms(b, y);
  std::vector<float> sums(size_t(a.width), 0.f);
  const size_t plane = size_t(a.height) * a.width;
  for (int c = 0; c < a.channels; ++c)
    for (int x = 0; x < a.width; ++x) {
      const float difference =
          row_a[c * plane + x] * norms_a[x] - row_b[c * plane + x] * norms_b[x];
      sums[x] += weights[c] * difference * difference;
    }
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

// d_a = (d_u - u (u . d_u)) / sqrt(|a|^2 + tiny), d_u = 2 w (u - v) times d_sum.
void RowDistanceVjp(const FeatureMap& a,
                    const FeatureMap& b,
                    const std::vector<float>& weights,
                    int y,
                    float d_sum,
                    std::vector<float>& d_a) {
  const size_t plane = size_t(a.height) * a.width, begin = size_t(y) * a.width;
  const std::vector<float> norms_a = RowNorms(a, y), norms_b = RowNorms(b, y);
  std::vector<float> along(size_t(a.width), 0.f);  // u . d_u
  for (int c = 0; c < a.channels; ++c)
    for (int x = 0; x < a.width; ++x) {
      const size_t i = c * plane + begin + x;
      const float u = a.data[i] * norms_a[x];
      d_a[i] = 2 * weights[c] * d_sum * (u - b.data[i] * norms_b[x]);
      along[x] += u * d_a[i];
    }
  for (int c = 0; c < a.channels; ++c)
    for (int x = 0; x < a.width; ++x) {
      const size_t i = c * plane + begin + x;
      d_a[i] = norms_a[x] * (d_a[i] - a.data[i] * norms_a[x] * along[x]);
    }
}

double MapDistance(const FeatureMap& a, const FeatureMap& b, const std::vector<float>& weights) {
  std::vector<double> rows(size_t(a.height));
  tbb::parallel_for(0, a.height, [&](int y) { rows[y] = RowDistance(a, b, weights, y); });
  return std::accumulate(rows.begin(), rows.end(), 0.0) / (double(a.height) * a.width);
}

std::vector<float> MapDistanceVjp(const FeatureMap& a,
                                  const FeatureMap& b,
                                  const std::vector<float>& weights) {
  const size_t pixels = size_t(a.height) * a.width;
  std::vector<float> d_a(pixels * size_t(a.channels));
  tbb::parallel_for(
      0, a.height, [&](int y) { RowDistanceVjp(a, b, weights, y, 1 / float(pixels), d_a); });
  return d_a;
}

OnnxNet ReadBackbone(const std::string& stem) {
  return OnnxNet(stem + kBackbone, ReadTaps(stem + "_taps.txt"));
}

// The networks take values in [-1, 1].
std::vector<float> FromUnit(View<const float> planes) {
  std::vector<float> out(planes.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = 2 * planes[i] - 1;
  return out;
}

bool IsFinite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace

Lpips::Lpips(const std::string& folder) : Lpips(folder, FindNet(folder)) {}

Lpips::Lpips(const std::string& folder, const std::string& net)
    : net_(net),
      backbone_(folder + "/" + net + kBackbone),
      nets_{ReadBackbone(folder + "/" + net), ReadBackbone(folder + "/" + net)} {
  const std::string stem = folder + "/" + net;
  weights_ = ReadWeights(stem + "_lin.npz", ReadTaps(stem + "_taps.txt"), nets_[0].channels());
}

std::vector<float> Lpips::ToPlanes(const Image8& image) const {
  if (image.channels != 3)
    throw Error(backbone_,
                "takes RGB images, not " + SizeText(image.width, image.height) + "x" +
                    std::to_string(image.channels));
  std::vector<float> planes(3 * image.pixels());
  for (size_t i = 0; i < image.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c)
      planes[c * image.pixels() + i] = float(image.data[3 * i + c]) / 127.5f - 1;
  return planes;
}

double Lpips::Run(
    const std::vector<float>& a, const std::vector<float>& b, int width, int height, bool keeps) {
  tbb::parallel_invoke([&] { maps_a_ = nets_[0].Run(a, width, height, keeps); },
                       [&] { maps_b_ = nets_[1].Run(b, width, height, false); });
  double sum = 0;
  for (size_t i = 0; i < weights_.size(); ++i)
    sum += MapDistance(maps_a_[i], maps_b_[i], weights_[i]);
  if (!std::isfinite(sum)) throw Error(backbone_, "produces non-finite feature maps");
  return sum;
}

double Lpips::Distance(const Image8& a, const Image8& b) {
  if (a.width != b.width || a.height != b.height)
    throw Error("images differ in size",
                SizeText(a.width, a.height) + " and " + SizeText(b.width, b.height));
  return Run(ToPlanes(a), ToPlanes(b), a.width, a.height, false);
}

double Lpips::Evaluate(View<const float> rendered,
                       View<const float> target,
                       int width,
                       int height,
                       std::vector<float>& d_rendered) {
  const double distance = Run(FromUnit(rendered), FromUnit(target), width, height, true);
  std::vector<std::vector<float>> d_maps;
  for (size_t i = 0; i < weights_.size(); ++i)
    d_maps.push_back(MapDistanceVjp(maps_a_[i], maps_b_[i], weights_[i]));
  d_rendered = nets_[0].Backward(d_maps);
  for (float& d : d_rendered) d *= 2;  // of FromUnit
  if (!IsFinite(d_rendered)) throw Error(backbone_, "has a gradient that is not finite");
  return distance;
}

}  // namespace cosplat
