#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/base/zip_archive.h"
#include "splat/io/packed_values.h"
#include "splat/io/sog.h"
#include "splat/io/sog_format.h"
#include "splat/io/splat_values.h"
#include "splat/media/webp.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

constexpr uint64_t kMaxMetaBytes = 1 << 20;  // meta.json has some 20 KB

// Whether a name is that of a file beside meta.json.
bool IsPlainName(const std::string& name) {
  return !name.empty() && name != ".." && name != "." && fs::path(name).filename() == name;
}

// meta.json and the images of a bundle or of a folder.
class SogFiles {
 public:
  explicit SogFiles(const std::string& path) : path_(path) {
    if (fs::is_directory(path)) {
      folder_ = path;
      path_ = (fs::path(path) / kSogMeta).string();
    } else if (fs::path(path).filename() == kSogMeta) {
      folder_ = fs::path(path).parent_path();
    } else {
      zip_.emplace(path, "SOG");
    }
  }
  const std::string& path() const { return path_; }
  // Bytes of all files together, as they are stored.
  uint64_t StoredBytes(const std::vector<std::string>& names) const {
    if (zip_) return fs::file_size(path_);
    uint64_t bytes = 0;
    std::error_code missing;  // is an error when it is read
    for (const std::string& name : names) {
      if (!IsPlainName(name)) continue;
      const uint64_t size = fs::file_size(folder_ / name, missing);
      bytes += missing ? 0 : size;
    }
    return bytes;
  }
  std::vector<char> Read(const std::string& name, uint64_t limit) const {
    if (!IsPlainName(name))
      throw Error(path_, "files", "'" + name + "' is not the name of a file beside meta.json");
    if (!zip_) {
      const std::string file = (folder_ / name).string();
      std::error_code missing;
      if (const uint64_t size = fs::file_size(file, missing); !missing && size > limit)
        throw Error(file, Format("has {} bytes, at most {} are accepted", size, limit));
      return ReadFile(file);
    }
    const size_t index = zip_->Find(name);
    if (index == zip_->size()) throw Error(path_, name, "is missing");
    return zip_->Read(index, limit);
  }

 private:
  std::string path_;
  fs::path folder_;
  std::optional<ZipReader> zip_;
};

class SogParser {
 public:
  SogParser(const SogFiles& files, const JsonField& meta) : files_(files), meta_(meta) {
    if (!meta.Has("version") && meta.Has("means"))
      Fail("version", "is missing: this is SOG of version 1, this program reads 2");
    const int version = meta["version"].Integer();
    if (version != kSogVersion) Fail("version", Format("is {}, this program reads 2", version));
    count_ = size_t(meta["count"].Integer(1, std::numeric_limits<int>::max()));
    std::vector<std::string> names;
    for (const char* property : {"means", "scales", "quats", "sh0", "shN"}) {
      if (!meta.Has(property)) continue;
      const JsonField list = meta[property]["files"];
      for (size_t i = 0; i < list.size(); ++i) names.push_back(list[i].String());
    }
    CheckSplatCount(files.path(), "count", count_, files.StoredBytes(names));
  }

  Gaussians Parse() const {
    Gaussians g;
    g.basis = Basis::kSh;
    if (IsAntialiased())
      SetAntialiased(files_.path(), meta_.NumberOr(kLowPassField, kBlurVariance), g);
    g.degree = meta_.Has("shN") ? meta_["shN"]["bands"].Integer(1, 3) : 0;
    for (size_t k = 0; k < 3 && meta_.Has(kSogOrigin); ++k)
      g.origin[k] = meta_[kSogOrigin][k].Number();
    g.Resize(count_);
    ReadPositions(g);
    ReadRotations(g);
    ReadScales(g);
    ReadColors(g);
    if (g.degree > 0) ReadBands(g);
    return g;
  }

 private:
  [[noreturn]] void Fail(const std::string& field, const std::string& problem) const {
    throw Error(files_.path(), field, problem);
  }
  // PlayCanvas' tools write `model`, their text has `antialias`.
  bool IsAntialiased() const {
    if (meta_.Has("model")) return meta_["model"].raw() == "antialiased";
    return meta_.Has("antialias") && meta_["antialias"].raw() == true;
  }
  std::vector<float> CodebookOf(const char* property) const {
    return meta_[property]["codebook"].Numbers(kSogCodebook);
  }
  Image8 Decode(const std::string& name, size_t max_pixels) const {
    constexpr uint64_t kMaxPerPixel = 8, kOverhead = 1 << 16;  // lossless WebP has 4 at most
    return DecodeWebp(
        files_.path(), name, files_.Read(name, kMaxPerPixel * max_pixels + kOverhead), max_pixels);
  }
  // An image with a pixel per splat; those that follow are ignored.
  Image8 PerSplat(const char* property, size_t index) const {
    const std::string name = meta_[property]["files"][index].String();
    constexpr size_t kPadding = 1 << 18;  // a few rows
    Image8 image = Decode(name, count_ + kPadding);
    if (image.pixels() < count_)
      Fail(name,
           "has " + SizeText(image.width, image.height) + " pixels, too few for " +
               std::to_string(count_) + " splats");
    return image;
  }

  void ReadPositions(Gaussians& g) const {
    const std::vector<float> low = meta_["means"]["mins"].Numbers(3);
    const std::vector<float> high = meta_["means"]["maxs"].Numbers(3);
    for (size_t k = 0; k < 3; ++k)
      if (low[k] > high[k]) Fail("means.mins", Format("is {:g}, maxs {:g}", low[k], high[k]));
    const Image8 lower = PerSplat("means", 0), upper = PerSplat("means", 1);
    for (size_t i = 0; i < count_; ++i)
      for (int k = 0; k < 3; ++k) {
        const int value = upper.data[4 * i + k] << 8 | lower.data[4 * i + k];
        const double share = value / kSogMaxPosition;
        const auto x = float(SogUnlog(low[k] * (1 - share) + high[k] * share));
        if (!std::isfinite(x)) Fail("means", Format("of splat {} are beyond a float's range", i));
        g.at(kPosition, i)[k] = x;
      }
  }
  void ReadRotations(Gaussians& g) const {
    const Image8 image = PerSplat("quats", 0);
    for (size_t i = 0; i < count_; ++i) {
      const uint8_t* in = &image.data[4 * i];
      const int largest = in[3] - kSogFirstMode;
      if (largest < 0)
        Fail(meta_["quats"]["files"][0].String(),
             Format("alpha of splat {} is {}, expected 252 to 255", i, in[3]));
      double squares = 0;
      for (int k = 0, next = 0; k < 4; ++k) {
        if (k == largest) continue;
        const double component = (2 * in[next++] / 255.0 - 1) * kSqrtHalf;
        g.at(kRotation, i)[k] = float(component);
        squares += component * component;
      }
      g.at(kRotation, i)[largest] = float(LargestOf(squares));
    }
  }
  void ReadScales(Gaussians& g) const {
    const std::vector<float> codebook = CodebookOf("scales");
    const Image8 image = PerSplat("scales", 0);
    for (size_t i = 0; i < count_; ++i)
      for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = codebook[image.data[4 * i + k]];
  }
  void ReadColors(Gaussians& g) const {
    const std::vector<float> codebook = CodebookOf("sh0");
    const Image8 image = PerSplat("sh0", 0);
    for (size_t i = 0; i < count_; ++i) {
      for (int k = 0; k < 3; ++k) g.at(kColorDc, i)[k] = codebook[image.data[4 * i + k]];
      *g.at(kOpacityLogit, i) = LogitOfByteShare(image.data[4 * i + 3] / 255.0);
    }
  }
  void ReadBands(Gaussians& g) const {
    const int colors = meta_["shN"]["count"].Integer(1, kSogMaxPalette);
    const std::vector<float> codebook = CodebookOf("shN");
    const int coefficients = CoefficientCount(g.degree) - 1;
    const int width = kSogPaletteRow * coefficients;
    const int rows = (colors + kSogPaletteRow - 1) / kSogPaletteRow;
    const std::string name = meta_["shN"]["files"][0].String();
    constexpr int kPaddingRows = 4;
    const Image8 palette = Decode(name, size_t(width) * size_t(rows + kPaddingRows));
    if (palette.width != width || palette.height < rows)
      Fail(name,
           "has " + SizeText(palette.width, palette.height) + " pixels, expected " +
               SizeText(width, rows));
    const Image8 labels = PerSplat("shN", 1);
    for (size_t i = 0; i < count_; ++i) {
      const int label = labels.data[4 * i] | labels.data[4 * i + 1] << 8;
      if (label >= colors)
        Fail(meta_["shN"]["files"][1].String(),
             Format("label of splat {} is {}, the palette has {}", i, label, colors));
      const uint8_t* in = &palette.data[4 * size_t(label) * size_t(coefficients)];
      for (int k = 0; k < 3 * coefficients; ++k)
        g.at(kColorRest, i)[k] = codebook[in[4 * (k / 3) + k % 3]];
    }
  }

  const SogFiles& files_;
  const JsonField& meta_;
  size_t count_;
};

}  // namespace

Gaussians ReadSog(const std::string& path) {
  const SogFiles files(path);
  const std::vector<char> text = files.Read(kSogMeta, kMaxMetaBytes);
  const std::string source = files.path() + ": " + kSogMeta;
  const JsonField meta(source, ParseJson(source, {text.begin(), text.end()}));
  return SogParser(files, meta).Parse();
}

bool IsSog(const std::string& path) {
  if (fs::is_directory(path)) return fs::exists(fs::path(path) / kSogMeta);
  if (fs::path(path).filename() == kSogMeta) return fs::exists(path);
  std::string bytes(4, '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), std::streamsize(bytes.size()));
  if (bytes != "PK\x03\x04") return false;
  const ZipReader zip(path, "SOG");
  return zip.Find(kSogMeta) < zip.size();
}

}  // namespace cosplat
