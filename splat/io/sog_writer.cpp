#include <algorithm>
#include <filesystem>
#include <limits>
#include <numeric>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/zip_archive.h"
#include "splat/io/color_weights.h"
#include "splat/io/kmeans.h"
#include "splat/io/packed_values.h"
#include "splat/io/sog.h"
#include "splat/io/sog_format.h"
#include "splat/io/splat_values.h"
#include "splat/math/morton.h"
#include "splat/media/webp.h"

namespace cosplat {
namespace {

// Gaussians with their positions in SOG's logarithmic domain, which is where 16 bits divide the
// box.
struct LogBox {
  std::vector<std::array<float, 3>> positions;
  std::array<float, 3> low, high;
};

LogBox BoxOf(const Gaussians& g) {
  LogBox box;
  box.low.fill(std::numeric_limits<float>::infinity());
  box.high.fill(-std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < g.size(); ++i) {
    std::array<float, 3>& p = box.positions.emplace_back();
    for (int k = 0; k < 3; ++k) {
      p[k] = float(SogLog(g.at(kPosition, i)[k]));
      box.low[k] = std::min(box.low[k], p[k]);
      box.high[k] = std::max(box.high[k], p[k]);
    }
  }
  return box;
}

std::vector<uint32_t> MortonOrderOf(const LogBox& box) {
  std::vector<uint64_t> codes;
  for (const auto& p : box.positions)
    codes.push_back(math::MortonCode(p.data(), box.low.data(), box.high.data()));
  std::vector<uint32_t> order(codes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(
      order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return codes[a] < codes[b]; });
  return order;
}

// 256 numbers in ascending order, so that neighbouring indices are neighbouring numbers, and the
// index of each of `numbers`.
struct Codebook {
  std::vector<float> numbers;
  std::vector<uint8_t> index;
};

Codebook CodebookOf(const std::vector<float>& numbers,
                    const std::vector<float>& weight,
                    uint64_t seed) {
  const Clusters clusters = KMeans(numbers, 1, weight, {kSogCodebook, 10, 1 << 16, seed});
  std::vector<uint32_t> order(clusters.centers.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return clusters.centers[a] < clusters.centers[b];
  });
  Codebook codebook;
  std::vector<uint8_t> place(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    codebook.numbers.push_back(clusters.centers[order[k]]);
    place[order[k]] = uint8_t(k);
  }
  codebook.numbers.resize(kSogCodebook, codebook.numbers.back());
  for (const uint32_t nearest : clusters.nearest) codebook.index.push_back(place[nearest]);
  return codebook;
}

// Three numbers per Gaussian of `attribute`, each with its Gaussian's weight.
Codebook CodebookOf(const Gaussians& g,
                    Attribute attribute,
                    const std::vector<float>& weight,
                    uint64_t seed) {
  std::vector<float> weights;
  for (const float w : weight) weights.insert(weights.end(), 3, w);
  return CodebookOf({g.values[attribute].begin(), g.values[attribute].end()}, weights, seed);
}

Image8 ImageFor(size_t count) {
  // Sides are multiples of four, as textures' in blocks must be.
  const int width = int(std::ceil(std::sqrt(double(count)) / 4)) * 4;
  const int height = int((count + 4 * size_t(width) - 1) / (4 * size_t(width))) * 4;
  return Image8(width, height, 4, uint8_t(255));
}

class SogWriter {
 public:
  SogWriter(const std::string& path, const SogSettings& settings)
      : path_(path), settings_(settings) {}

  void Positions(const LogBox& box) {
    Image8 low = ImageFor(box.positions.size()), high = low;
    for (size_t i = 0; i < box.positions.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const double side = double(box.high[k]) - box.low[k];
        const double share = side > 0 ? (double(box.positions[i][k]) - box.low[k]) / side : 0;
        const auto value = uint16_t(std::lround(kSogMaxPosition * share));
        low.data[4 * i + k] = uint8_t(value);
        high.data[4 * i + k] = uint8_t(value >> 8);
      }
    meta_["means"] = {{"mins", box.low}, {"maxs", box.high}};
    AddImage("means", "means_l.webp", low);
    AddImage("means", "means_u.webp", high);
  }
  void Rotations(const Gaussians& g) {
    Image8 image = ImageFor(g.size());
    for (size_t i = 0; i < g.size(); ++i) {
      const float* r = g.at(kRotation, i);
      std::array<double, 4> q{r[0], r[1], r[2], r[3]};
      const int largest = NormalizeByLargest(q);
      uint8_t* out = &image.data[4 * i];
      for (int k = 0, next = 0; k < 4; ++k)
        if (k != largest) out[next++] = uint8_t(std::lround(255 * (0.5 + 0.5 * q[k] / kSqrtHalf)));
      out[3] = uint8_t(kSogFirstMode + largest);
    }
    AddImage("quats", "quats.webp", image);
  }
  void Scales(const Gaussians& g, const std::vector<float>& weight) {
    const Codebook codebook = CodebookOf(g, kScaleLog, weight, settings_.seed);
    Image8 image = ImageFor(g.size());
    for (size_t i = 0; i < g.size(); ++i)
      std::copy_n(&codebook.index[3 * i], 3, &image.data[4 * i]);
    meta_["scales"]["codebook"] = codebook.numbers;
    AddImage("scales", "scales.webp", image);
  }
  void Colors(const Gaussians& g, const std::vector<float>& weight) {
    const Codebook codebook = CodebookOf(g, kColorDc, weight, settings_.seed);
    Image8 image = ImageFor(g.size());
    for (size_t i = 0; i < g.size(); ++i) {
      std::copy_n(&codebook.index[3 * i], 3, &image.data[4 * i]);
      image.data[4 * i + 3] = ByteOfLogit(*g.at(kOpacityLogit, i));
    }
    meta_["sh0"]["codebook"] = codebook.numbers;
    AddImage("sh0", "sh0.webp", image);
  }
  // Also moves what the palette lacks into the constant colours, which are to be written next.
  // seen: SeenBands of g, or empty.
  void Bands(const std::vector<float>& weight, const std::vector<float>& seen, Gaussians& g) {
    const int coefficients = CoefficientCount(g.degree) - 1;
    const size_t width = 3 * size_t(coefficients);
    const Clusters palette = KMeans(g.values[kColorRest],
                                    width,
                                    weight,
                                    {size_t(settings_.palette), 10, 1 << 16, settings_.seed});
    const size_t colors = palette.centers.size() / width;
    const Codebook codebook = CodebookOf({palette.centers.begin(), palette.centers.end()},
                                         std::vector<float>(palette.centers.size(), 1.f),
                                         settings_.seed);
    Image8 image(kSogPaletteRow * coefficients,
                 int((colors + kSogPaletteRow - 1) / kSogPaletteRow),
                 4,
                 uint8_t(255));
    for (size_t i = 0; i < codebook.index.size(); ++i)
      image.data[4 * (i / 3) + i % 3] = codebook.index[i];
    std::vector<float> stored(codebook.index.size());  // the palette as it is read back
    for (size_t i = 0; i < stored.size(); ++i) stored[i] = codebook.numbers[codebook.index[i]];
    for (size_t i = 0; i < g.size() && !seen.empty(); ++i)
      MoveErrorToDc(g.at(kColorRest, i),
                    &stored[width * palette.nearest[i]],
                    &seen[size_t(coefficients) * i],
                    g.degree,
                    g.at(kColorDc, i));
    Image8 labels = ImageFor(g.size());
    for (size_t i = 0; i < g.size(); ++i) {
      labels.data[4 * i] = uint8_t(palette.nearest[i]);
      labels.data[4 * i + 1] = uint8_t(palette.nearest[i] >> 8);
      labels.data[4 * i + 2] = 0;
    }
    meta_["shN"] = {{"count", colors}, {"bands", g.degree}, {"codebook", codebook.numbers}};
    AddImage("shN", "shN_centroids.webp", image);
    AddImage("shN", "shN_labels.webp", labels);
  }
  void Finish(const Gaussians& g) {
    meta_["version"] = kSogVersion;
    meta_["asset"]["generator"] = "CoSplat";
    meta_["count"] = g.size();
    meta_["antialias"] = g.antialiased;
    if (g.antialiased) {
      meta_["model"] = "antialiased";
      meta_[kLowPassField] = LowPassNumber(g);
    }
    if (g.origin != WorldOrigin{}) meta_[kSogOrigin] = g.origin;
    const std::string text = meta_.dump() + "\n";
    if (!path_.ends_with(kSogMeta)) {
      images_.insert(images_.begin(), ZipMember{kSogMeta, text});
      return WriteZip(path_, images_);
    }
    const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
    for (const ZipMember& image : images_)
      WriteFileAtomically((folder / image.name).string(), image.bytes);
    WriteFileAtomically(path_, text);
  }

 private:
  void AddImage(const std::string& property, const std::string& name, const Image8& image) {
    meta_[property]["files"].push_back(name);
    images_.push_back({name, EncodeWebp(path_, name, image), false});
  }

  std::string path_;
  SogSettings settings_;
  Json meta_;
  std::vector<ZipMember> images_;
};

}  // namespace

void WriteSog(const std::string& path,
              const Gaussians& gaussians,
              View<const float> significance,
              const SogSettings& settings) {
  CheckForSplatFile(path, gaussians);
  if (settings.palette < 1 || settings.palette > kSogMaxPalette)
    throw Error(path, "palette", "is " + std::to_string(settings.palette) + ", not 1 to 65536");
  LogBox box = BoxOf(gaussians);
  const std::vector<uint32_t> order = MortonOrderOf(box);
  Gaussians g = gaussians;
  g.Gather(order);
  HideWithoutRotation(g);
  const std::vector<float> weights = WeightsOf(significance);
  std::vector<float> weight;
  LogBox ordered{{}, box.low, box.high};
  for (const uint32_t i : order) {
    weight.push_back(weights[i]);
    ordered.positions.push_back(box.positions[i]);
  }
  std::vector<float> seen;
  if (!settings.seen_bands.empty()) {
    const size_t width = size_t(CoefficientCount(g.degree) - 1);
    for (const uint32_t i : order)
      for (size_t k = 0; k < width; ++k) seen.push_back(settings.seen_bands[width * i + k]);
  }
  SogWriter writer(path, settings);
  writer.Positions(ordered);
  writer.Rotations(g);
  writer.Scales(g, weight);
  if (g.degree > 0) writer.Bands(weight, seen, g);
  writer.Colors(g, weight);
  writer.Finish(g);
}

}  // namespace cosplat
