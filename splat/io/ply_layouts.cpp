#include "splat/io/ply_layouts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "splat/base/text.h"
#include "splat/io/packed_values.h"
#include "splat/io/splat_values.h"

namespace cosplat {
namespace {

constexpr size_t kChunkSize = 256;
constexpr std::array<const char*, 4> kPacked{
    "packed_position", "packed_rotation", "packed_scale", "packed_color"};

// What a chunk has bounds of: positions, logarithms of scales and, except in older files, colours.
constexpr std::array<const char*, 9> kBounded{
    "x", "y", "z", "scale_x", "scale_y", "scale_z", "r", "g", "b"};
constexpr int kScaleAxis = 3, kColorAxis = 6;

struct Chunk {
  std::array<float, 9> low{}, high{1, 1, 1, 1, 1, 1, 1, 1, 1};
  double At(int axis, double share) const { return low[axis] * (1 - share) + high[axis] * share; }
};

// `count` bits of `packed` from bit `first` on, as a fraction of their largest value.
double Share(uint32_t packed, int first, int count) {
  const uint32_t largest = (1u << count) - 1;
  return double(packed >> first & largest) / largest;
}

std::vector<Chunk> ReadChunks(PlyReader& reader) {
  reader.Enter("chunk");
  std::vector<int> low, high;
  const int axes = reader.Find("min_r") >= 0 ? int(kBounded.size()) : kColorAxis;
  for (int k = 0; k < axes; ++k) {
    low.push_back(reader.Require(std::string("min_") + kBounded[k]));
    high.push_back(reader.Require(std::string("max_") + kBounded[k]));
  }
  std::vector<Chunk> chunks(reader.count());
  for (Chunk& chunk : chunks) {
    const std::vector<double>& row = reader.Next();
    const auto finite = [&](int index) {
      const float value = float(row[index]);
      if (!std::isfinite(value)) reader.Fail(reader.properties()[index], "is not finite");
      return value;
    };
    for (int k = 0; k < axes; ++k) {
      chunk.low[k] = finite(low[k]);
      chunk.high[k] = finite(high[k]);
    }
    for (const auto& bounds : {chunk.low, chunk.high})
      for (int k = kColorAxis; k < axes; ++k)
        if (!std::isfinite(DcOfColor(bounds[k])))
          reader.Fail("has a bound of colours of " + std::to_string(bounds[k]));
  }
  return chunks;
}

// A value of the current row that must be an integer in [0, largest].
uint32_t Whole(const PlyReader& reader,
               const std::vector<double>& row,
               int index,
               uint32_t largest) {
  const double value = row[index];
  if (!(value >= 0 && value <= largest && value == std::floor(value)))
    reader.Fail(reader.properties()[index],
                Format("is {}, expected a whole number up to {}", value, largest));
  return uint32_t(value);
}

// The largest component follows from the others, since the norm is 1.
void UnpackRotation(uint32_t packed, float* wxyz) {
  const int largest = int(packed >> 30);
  double squares = 0;
  for (int k = 0, bit = 20; k < 4; ++k) {
    if (k == largest) continue;
    const double component = (2 * Share(packed, bit, 10) - 1) * kSqrtHalf;
    wxyz[k] = float(component);
    squares += component * component;
    bit -= 10;
  }
  wxyz[largest] = float(LargestOf(squares));
}

void UnpackVertex(const std::array<uint32_t, 4>& packed,
                  const Chunk& chunk,
                  size_t i,
                  Gaussians& gaussians) {
  constexpr std::array<int, 3> kFirst{21, 11, 0}, kCount{11, 10, 11};
  const auto [position, rotation, scale, color] = packed;
  for (int k = 0; k < 3; ++k) {
    const double share = Share(position, kFirst[k], kCount[k]);
    gaussians.at(kPosition, i)[k] = float(chunk.At(k, share));
    gaussians.at(kScaleLog, i)[k] =
        float(chunk.At(kScaleAxis + k, Share(scale, kFirst[k], kCount[k])));
    gaussians.at(kColorDc, i)[k] = DcOfColor(chunk.At(kColorAxis + k, Share(color, 24 - 8 * k, 8)));
  }
  UnpackRotation(rotation, gaussians.at(kRotation, i));
  *gaussians.at(kOpacityLogit, i) = LogitOfByteShare(Share(color, 0, 8));
}

std::vector<std::array<uint32_t, 4>> ReadVertices(PlyReader& reader) {
  reader.Enter("vertex");
  std::array<int, 4> columns;
  for (size_t k = 0; k < columns.size(); ++k) columns[k] = reader.Require(kPacked[k]);
  std::vector<std::array<uint32_t, 4>> vertices(reader.count());
  for (std::array<uint32_t, 4>& vertex : vertices) {
    const std::vector<double>& row = reader.Next();
    for (size_t k = 0; k < columns.size(); ++k)
      vertex[k] = Whole(reader, row, columns[k], UINT32_MAX);
  }
  return vertices;
}

// The middle of bin `byte` of the 256 bins of -4 .. 4; the first and last bins, to which values
// beyond are clamped, give -4 and 4.
float RestOfByte(uint32_t byte) {
  if (byte == 0) return -4;
  return byte == UINT8_MAX ? 4 : 8 * ((float(byte) + 0.5f) / 256 - 0.5f);
}

// Sets the degree and fills the bands.
void ReadRest(PlyReader& reader, Gaussians& gaussians) {
  const size_t count = gaussians.size();
  reader.Enter("sh");
  if (reader.count() != count)
    reader.Fail(Format("has {} rows, expected one for each of {} vertices", reader.count(), count));
  gaussians.degree = DegreeOf(reader);
  gaussians.Resize(count);
  const std::vector<PlyColumn> columns = RestColumns(CoefficientCount(gaussians.degree) - 1);
  std::vector<int> source;
  for (const PlyColumn& column : columns) source.push_back(reader.Require(column.name));
  for (size_t i = 0; i < count; ++i) {
    const std::vector<double>& row = reader.Next();
    for (size_t k = 0; k < columns.size(); ++k)
      gaussians.at(kColorRest, i)[columns[k].component] =
          RestOfByte(Whole(reader, row, source[k], UINT8_MAX));
  }
}

}  // namespace

bool IsCompressed(const PlyReader& reader) {
  return std::any_of(
      kPacked.begin(), kPacked.end(), [&](const char* name) { return reader.Has("vertex", name); });
}

Gaussians ReadCompressed(PlyReader& reader) {
  const std::vector<Chunk> chunks = ReadChunks(reader);
  const std::vector<std::array<uint32_t, 4>> vertices = ReadVertices(reader);
  const size_t expected = (vertices.size() + kChunkSize - 1) / kChunkSize;
  if (chunks.size() != expected)
    reader.Fail("has " + std::to_string(vertices.size()) + " rows, which need " +
                std::to_string(expected) + " chunks, not " + std::to_string(chunks.size()));
  Gaussians gaussians;
  gaussians.basis = Basis::kSh;
  gaussians.Resize(vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i)
    UnpackVertex(vertices[i], chunks[i / kChunkSize], i, gaussians);
  ReadMarks(reader, gaussians);
  if (reader.Has("sh", "f_rest_0")) ReadRest(reader, gaussians);
  return gaussians;
}

std::vector<PlyColumn> SplatColumns(int degree) {
  std::vector<PlyColumn> columns{{"x", kPosition, 0}, {"y", kPosition, 1}, {"z", kPosition, 2}};
  for (int i = 0; i < 3; ++i) columns.push_back({"f_dc_" + std::to_string(i), kColorDc, i});
  for (PlyColumn& column : RestColumns(CoefficientCount(degree) - 1)) columns.push_back(column);
  columns.push_back({"opacity", kOpacityLogit, 0});
  for (int i = 0; i < 3; ++i) columns.push_back({"scale_" + std::to_string(i), kScaleLog, i});
  for (int i = 0; i < 4; ++i) columns.push_back({"rot_" + std::to_string(i), kRotation, i});
  return columns;
}

std::vector<PlyColumn> RestColumns(int coefficients) {
  std::vector<PlyColumn> columns;
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < coefficients; ++k)
      columns.push_back({"f_rest_" + std::to_string(columns.size()), kColorRest, 3 * k + c});
  return columns;
}

int DegreeOf(const PlyReader& reader) {
  int rest = 0;
  for (const std::string& name : reader.properties()) rest += name.starts_with("f_rest_");
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree)
    if (rest == 3 * (CoefficientCount(degree) - 1)) return degree;
  reader.Fail("has " + std::to_string(rest) + " properties f_rest_*, expected 0, 9, 24, 45 or 72");
}

std::string MarksOf(const Gaussians& gaussians) {
  if (!gaussians.antialiased) return "";
  return std::string("comment SplatRenderMode: mip\ncomment ") + kLowPassField +
         (LowPassNumber(gaussians) == 0.3 ? " 0.3\n" : " 0.1\n");
}

void ReadMarks(const PlyReader& reader, Gaussians& gaussians) {
  bool antialiased = false;
  double variance = kBlurVariance;
  for (const std::string& comment : reader.comments()) {
    if (comment == "Exported from Brush") variance = kAntialiasedBlurVariance;
    std::istringstream words(comment);
    std::string name, value;
    words >> name >> value;
    name = LowerCase(name), value = LowerCase(value);
    if (name == "splatrendermode:") antialiased = value == "mip";
    if (name == kLowPassField) variance = std::strtod(value.c_str(), nullptr);
    if (name != "antialiased") continue;
    antialiased = value != "0";
    if (value.empty()) variance = kAntialiasedBlurVariance;
  }
  if (antialiased) SetAntialiased(reader.path(), variance, gaussians);
}

}  // namespace cosplat
