#include "splat/io/ply.h"

#include <array>
#include <bit>
#include <cmath>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/io/ply_layouts.h"
#include "splat/io/ply_reader.h"
#include "splat/io/splat_values.h"

namespace cosplat {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are written as stored");

// What laser scanners' programs (XGRIDS, DJI Terra) write above Gaussians and points: the world's
// coordinates are those of the file plus these.
std::string OffsetsOf(const WorldOrigin& origin) {
  std::string comments;
  for (size_t k = 0; k < 3 && origin != WorldOrigin{}; ++k)
    comments += "comment " + std::string(kPlyOffsets[k]) + " " + Json(origin[k]).dump() + "\n";
  return comments;
}

// comments: whole lines.
std::string HeaderOf(size_t count, const std::string& comments = "") {
  return Format("ply\nformat binary_little_endian 1.0\n{}element vertex {}\n", comments, count);
}

void CheckForPly(const std::string& path, const Gaussians& gaussians) {
  if (gaussians.basis != Basis::kSh)
    throw Error(path, "basis", "is " + ToString(gaussians.basis) + ", PLY files hold sh");
  if (!gaussians.smoothing.empty()) throw Error(path, "smoothing", "is not part of the scales");
}

constexpr int kNormals = 3, kNormalsAt = 3;

void WriteSplatHeader(const Gaussians& layout, size_t count, std::ostream& out) {
  const std::vector<PlyColumn> columns = SplatColumns(layout.degree);
  out << HeaderOf(count, MarksOf(layout) + OffsetsOf(layout.origin));
  for (size_t i = 0; i < columns.size(); ++i) {
    if (i == kNormalsAt) out << "property float nx\nproperty float ny\nproperty float nz\n";
    out << "property float " << columns[i].name << "\n";
  }
  out << "end_header\n";
}

// first: the number of rows before these, for messages.
void WriteRows(const std::string& path,
               const Gaussians& gaussians,
               size_t first,
               std::ostream& out) {
  const std::vector<PlyColumn> columns = SplatColumns(gaussians.degree);
  std::vector<float> row(columns.size() + kNormals, 0.0f);
  for (size_t i = 0; i < gaussians.size(); ++i) {
    for (size_t k = 0; k < columns.size(); ++k) {
      const float value = gaussians.at(columns[k].attribute, i)[columns[k].component];
      if (!std::isfinite(value))
        throw Error(path, Format("vertex {}, {}", first + i, columns[k].name), "is not finite");
      row[k < kNormalsAt ? k : k + kNormals] = value;
    }
    // The last are opacity, scale_0..2, rot_0..3.
    HideWithoutRotation(&row[row.size() - 4], row[row.size() - 8]);
    out.write(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(float));
  }
}

}  // namespace

void WritePly(const std::string& path, const Gaussians& gaussians) {
  CheckForPly(path, gaussians);
  WriteFileAtomically(path, [&](std::ostream& out) {
    WriteSplatHeader(gaussians, gaussians.size(), out);
    WriteRows(path, gaussians, 0, out);
  });
}

void WritePly(const std::string& path,
              size_t count,
              size_t parts,
              const std::function<Gaussians(size_t)>& part) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    size_t written = 0;
    for (size_t i = 0; i < parts; ++i) {
      const Gaussians gaussians = part(i);
      CheckForPly(path, gaussians);
      if (i == 0) WriteSplatHeader(gaussians, count, out);
      WriteRows(path, gaussians, written, out);
      written += gaussians.size();
    }
    if (written != count)
      throw Error(path, Format("its parts have {} vertices, not {}", written, count));
  });
}

bool IsCompressedPly(const std::string& path) { return IsCompressed(PlyReader(path)); }

void WritePointsPly(const std::string& path,
                    const std::vector<float>& points,
                    const std::vector<uint8_t>& colors,
                    const WorldOrigin& origin) {
  if (points.size() != colors.size() || points.size() % 3 != 0)
    throw Error(path,
                Format("{} coordinates do not fit {} colour values", points.size(), colors.size()));
  const size_t count = points.size() / 3;
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << HeaderOf(count, OffsetsOf(origin));
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
      out << "property float " << name << "\n";
    for (const char* name : {"red", "green", "blue"}) out << "property uchar " << name << "\n";
    out << "end_header\n";
    for (size_t i = 0; i < count; ++i) {
      const float row[6] = {points[3 * i], points[3 * i + 1], points[3 * i + 2], 0, 0, 0};
      out.write(reinterpret_cast<const char*>(row), sizeof(row));
      out.write(reinterpret_cast<const char*>(&colors[3 * i]), 3);
    }
  });
}

bool ReadPointsPly(const std::string& path,
                   std::vector<double>& points,
                   std::vector<uint8_t>& colors) {
  PlyReader reader(path);
  reader.Enter("vertex");
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"}, kColors{"red", "green", "blue"};
  std::array<int, 3> position, color;
  for (int k = 0; k < 3; ++k) position[k] = reader.Require(kAxes[k]);
  for (int k = 0; k < 3; ++k) color[k] = reader.Find(kColors[k]);
  constexpr uint8_t kGrey = 128;
  points.assign(3 * reader.count(), 0);
  colors.assign(3 * reader.count(), kGrey);
  for (size_t i = 0; i < reader.count(); ++i) {
    const std::vector<double>& values = reader.Next();
    for (int k = 0; k < 3; ++k) {
      points[3 * i + k] = values[position[k]];
      if (!std::isfinite(float(points[3 * i + k]))) reader.Fail(kAxes[k], "is not finite");
      if (color[k] < 0) continue;
      const double value = values[color[k]];
      if (!(value >= 0 && value <= 255)) reader.Fail(kColors[k], "is not in 0..255");
      colors[3 * i + k] = uint8_t(value);
    }
  }
  return reader.IsDouble("x");
}

}  // namespace cosplat
