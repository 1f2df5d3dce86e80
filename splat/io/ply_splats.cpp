// Reads splats from PLY files: 3DGS's, and what other programs have made of it.
#include <algorithm>
#include <cmath>
#include <set>

#include "splat/base/error.h"
#include "splat/io/packed_values.h"
#include "splat/io/ply.h"
#include "splat/io/ply_layouts.h"
#include "splat/io/ply_reader.h"
#include "splat/io/splat_values.h"

namespace cosplat {
namespace {

constexpr const char* kMipFilter = "filter_3D";
constexpr const char* kColors[] = {"red", "green", "blue"};

void RefuseOtherKinds(const PlyReader& reader) {
  const auto has = [&](const char* name) { return reader.Find(name) >= 0; };
  if (has("f_anchor_feat_0") || has("f_offset_0"))
    throw Error(reader.path(),
                "holds anchors of Scaffold-GS, not splats: its networks make those for each view");
  if (!has("opacity") && !has("scale_0") && !has("rot_0") && !has("f_dc_0"))
    throw Error(reader.path(),
                "holds points or a mesh, not splats: it has no opacity, scale_0, rot_0 and f_dc_0");
}

std::string Listed(const std::vector<std::string>& names) {
  constexpr size_t kShown = 6;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kShown); ++i) text += (i ? ", " : "") + names[i];
  return names.size() > kShown ? text + ", ..." : text;
}

// positions: [N, 3]. Far from zero they are counted from a place near them.
void SetPositions(const std::vector<double>& positions, Gaussians& gaussians) {
  const WorldOrigin near =
      OriginNearPoints(gaussians.size(), [&](size_t i) { return &positions[3 * i]; });
  for (size_t i = 0; i < positions.size(); ++i)
    gaussians.values[kPosition][i] = float(positions[i] - near[i % 3]);
  for (size_t k = 0; k < 3; ++k) gaussians.origin[k] += near[k];
}

// The rows of the element that the reader has entered.
class SplatRows {
 public:
  explicit SplatRows(PlyReader& reader)
      : reader_(reader),
        degree_(DegreeOf(reader)),
        columns_(SplatColumns(degree_)),
        discs_(reader.Find("scale_1") >= 0 && reader.Find("scale_2") < 0),
        bytes_(reader.Find("f_dc_0") < 0 && reader.Find(kColors[0]) >= 0),
        filter_(reader.Find(kMipFilter)) {
    for (const PlyColumn& column : columns_) source_.push_back(SourceOf(column));
  }

  Gaussians Read() {
    Gaussians g;
    g.degree = degree_;
    g.basis = Basis::kSh;
    ReadMarks(reader_, g);
    g.Resize(reader_.count());
    std::vector<double> exact;  // positions that floats may be too coarse for
    const bool doubles = reader_.IsDouble("x");
    for (size_t i = 0; i < g.size(); ++i) {
      const std::vector<double>& row = reader_.Next();
      for (size_t k = 0; k < 3 && doubles; ++k) exact.push_back(row[size_t(source_[k])]);
      for (size_t k = 0; k < columns_.size(); ++k)
        g.at(columns_[k].attribute, i)[columns_[k].component] = Value(row, k);
      if (filter_ >= 0) g.smoothing.push_back(Smoothing(row[size_t(filter_)]));
    }
    if (AreShares())
      for (float& dc : g.values[kColorDc])
        dc = DcOfColor(255 * (0.5 + BasisConstants(Basis::kSh)[0] * double(dc)));
    if (doubles) SetPositions(exact, g);
    if (filter_ >= 0) SetAntialiased(reader_.path(), kAntialiasedBlurVariance, g);
    return g;
  }

  // What a user should know of how the file is read.
  void Note(std::vector<std::string>& notes) const {
    if (discs_)
      notes.push_back("has discs of two scales (2DGS): they are drawn as flat Gaussians, by 3DGS");
    if (filter_ >= 0)
      notes.push_back(
          "has the 3D filter of Mip-Splatting: it is made part of scales and opacities");
    if (AreShares()) notes.push_back("has colours from 0 to 1, not 255: they are read as shares");
    std::set<std::string> read{"nx", "ny", "nz", "red", "green", "blue", "alpha", kMipFilter};
    for (const PlyColumn& column : columns_) read.insert(column.name);
    std::vector<std::string> others;
    for (const std::string& name : reader_.properties())
      if (!read.contains(name)) others.push_back(name);
    if (!others.empty())
      notes.push_back(
          "has " + std::to_string(others.size()) +
          " properties that are not read, what they mean is not in the picture: " + Listed(others));
  }

 private:
  int SourceOf(const PlyColumn& column) const {
    if (bytes_ && column.attribute == kColorDc) return reader_.Require(kColors[column.component]);
    if (discs_ && column.attribute == kScaleLog && column.component == 2) return -1;
    return reader_.Require(column.name);
  }
  bool AreShares() const { return bytes_ && fractions_ && most_ <= 1; }
  float Value(const std::vector<double>& row, size_t k) {
    if (source_[k] < 0) return -kLargestScaleLog;
    const PlyColumn& column = columns_[k];
    double value = row[size_t(source_[k])];
    if (bytes_ && column.attribute == kColorDc) {
      if (!(value >= 0 && value <= 255))
        reader_.Fail(kColors[column.component], "is not in 0..255");
      most_ = std::max(most_, value);
      fractions_ |= value != std::floor(value);
      value = DcOfColor(value / 255);
    }
    if (!IsSplatNumber(column.attribute, float(value))) reader_.Fail(column.name, "is not finite");
    return float(value);
  }
  float Smoothing(double filter) const {
    const auto variance = float(filter * filter);
    if (!(filter >= 0 && std::isfinite(variance))) reader_.Fail(kMipFilter, "is not a length");
    return variance;
  }

  PlyReader& reader_;
  int degree_;
  std::vector<PlyColumn> columns_;
  bool discs_;              // 2DGS: no third scale
  bool bytes_;              // colours as bytes instead of coefficients (nerfstudio)
  double most_ = 0;         // of those
  bool fractions_ = false;  // whether some are between two bytes
  int filter_;              // of Mip-Splatting, world units; -1: none
  std::vector<int> source_;
};

}  // namespace

Gaussians ReadPly(const std::string& path, std::vector<std::string>* notes) {
  PlyReader reader(path);
  Gaussians g;
  size_t left = 0;
  if (IsCompressed(reader)) {
    g = ReadCompressed(reader);
    left = reader.BytesLeftOver();
  } else {
    reader.Enter("vertex");
    RefuseOtherKinds(reader);
    left = reader.BytesLeftOver();
    SplatRows rows(reader);
    g = rows.Read();
    if (notes) rows.Note(*notes);
  }
  for (size_t k = 0; k < 3; ++k) g.origin[k] += reader.CommentNumber(kPlyOffsets[k], 0);
  if (notes && left > 0)
    notes->push_back("has " + std::to_string(left) + " bytes that its header does not mention");
  SettleSplats(g, notes);
  BakeSmoothing(g);
  return g;
}

}  // namespace cosplat
