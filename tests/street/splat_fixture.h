// Splat files as other programs write them: any numbers, any header.
#pragma once

#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "splat/base/files.h"
#include "splat/io/color_weights.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_file.h"
#include "splat/io/spz.h"
#include "tests/support/looking_at.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

// A property of a PLY file with its values, one per splat.
struct PlyColumnData {
  std::string name;
  std::vector<float> values;
};

// 3DGS's properties of the Gaussians, whatever their numbers.
inline std::vector<PlyColumnData> ColumnsOfPly(const Gaussians& g) {
  std::vector<PlyColumnData> columns;
  const auto add = [&](const std::string& name, Attribute attribute, int component) {
    columns.push_back({name, {}});
    for (size_t i = 0; i < g.size(); ++i)
      columns.back().values.push_back(g.at(attribute, i)[component]);
  };
  const char* axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) add(axes[k], kPosition, k);
  for (int k = 0; k < 3; ++k) add("f_dc_" + std::to_string(k), kColorDc, k);
  const int rest = g.width(kColorRest);
  for (int k = 0; k < rest; ++k)
    add("f_rest_" + std::to_string(k), kColorRest, 3 * (k % (rest / 3)) + k / (rest / 3));
  add("opacity", kOpacityLogit, 0);
  for (int k = 0; k < 3; ++k) add("scale_" + std::to_string(k), kScaleLog, k);
  for (int k = 0; k < 4; ++k) add("rot_" + std::to_string(k), kRotation, k);
  return columns;
}

struct PlyLook {
  std::string comments = "";  // whole lines
  std::string newline = "\n";
  bool big_endian = false;
  size_t stated_count = 0;  // 0: the true one
};

inline std::string PlyBytes(const std::vector<PlyColumnData>& columns, const PlyLook& look = {}) {
  const size_t count = columns[0].values.size();
  std::string header = std::string("ply\nformat ") +
                       (look.big_endian ? "binary_big_endian" : "binary_little_endian") + " 1.0\n" +
                       look.comments + "element vertex " +
                       std::to_string(look.stated_count ? look.stated_count : count) + "\n";
  for (const PlyColumnData& column : columns) header += "property float " + column.name + "\n";
  std::string bytes;
  for (const char c : header + "end_header\n")
    bytes += c == '\n' ? look.newline : std::string(1, c);
  for (size_t i = 0; i < count; ++i)
    for (const PlyColumnData& column : columns) {
      char number[sizeof(float)];
      std::memcpy(number, &column.values[i], sizeof number);
      for (size_t k = 0; k < sizeof number; ++k)
        bytes += number[look.big_endian ? sizeof number - 1 - k : k];
    }
  return bytes;
}

inline std::string SavedPly(const TemporaryFolder& folder,
                            const Gaussians& g,
                            const PlyLook& look = {},
                            const std::string& name = "theirs.ply") {
  WriteFileAtomically(folder / name, PlyBytes(ColumnsOfPly(g), look));
  return folder / name;
}

inline std::string BytesOf(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

// One file of every layout that is written.
inline std::vector<std::string> Exported(const TemporaryFolder& folder, const Gaussians& g) {
  WritePly(folder / "ours.ply", g);
  WriteSceneGlb(folder / "ours.glb", g);
  WriteSog(folder / "ours.sog", g, SizeSignificance(g), {});
  std::vector<std::string> files{folder / "ours.ply", folder / "ours.glb", folder / "ours.sog"};
  for (int version = 2; version <= 4; ++version) {
    files.push_back(folder / ("ours" + std::to_string(version) + ".spz"));
    WriteSpz(files.back(), g, {}, version);
  }
  return files;
}

inline Camera InFront(int side = 64) { return LookingAt({0, 0, -3}, {0, 0, 0}, side); }

inline double PsnrOf(const RenderedImage& a, const RenderedImage& b) {
  double sum = 0;
  for (size_t i = 0; i < a.color.size(); ++i)
    sum += std::pow(double(a.color[i]) - double(b.color[i]), 2);
  return -10 * std::log10(std::max(sum / double(a.color.size()), 1e-12));
}
inline double PsnrOf(const Gaussians& a, const Gaussians& b, int side = 64) {
  return PsnrOf(Image(a, InFront(side)), Image(b, InFront(side)));
}

inline bool AllAreFinite(const Gaussians& g) {
  for (const auto& values : g.values)
    for (const float x : values)
      if (!std::isfinite(x)) return false;
  return true;
}

// Whether one of the lines has this text.
inline bool Mentions(const std::vector<std::string>& lines, const std::string& text) {
  for (const std::string& line : lines)
    if (line.find(text) != std::string::npos) return true;
  return false;
}

}  // namespace cosplat::test
