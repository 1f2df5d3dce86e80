#include "splat/io/spz.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/median.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"
#include "splat/io/color_weights.h"
#include "splat/io/packed_values.h"
#include "splat/io/splat_primitive.h"
#include "splat/io/splat_values.h"

namespace cosplat {
namespace {

constexpr uint32_t kSpzMagic = 0x5053474e;  // "NGSP"
constexpr int kLatestSpzVersion = 4;
constexpr double kColorScale = 0.15;     // per coefficient of the constant colour, of 0..1
constexpr double kScaleSteps = 16;       // per unit of the log scale
constexpr double kLowestScaleLog = -10;  // of byte 0
// Bits of a coefficient's byte that are used, of band 1 and of higher ones: the others are zero and
// deflate to little. On garden (docs/files.md) Niantic's 5 and 4 lose 0.31 dB at 5.9 MB, these 0.07
// dB at 7.2 MB, 8 and 8 nothing at 11.1 MB.
constexpr int kBitsOfBand1 = 6, kBitsOfHigherBands = 5;
// Bits of the flags. The last, which SPZ leaves unused, says that the low-pass filter is ours.
constexpr uint8_t kSpzAntialiased = 1, kSpzExtensions = 2, kSpzOurLowPass = 1 << 7;
constexpr int kSpzHeader = 16, kHeaderOfVersion4 = 32;

struct SpzHeader {
  uint32_t magic = kSpzMagic;
  uint32_t version = 0;
  uint32_t count = 0;
  uint8_t degree = 0;
  uint8_t fractional_bits = 0;
  uint8_t flags = 0;
  uint8_t streams = 0;  // of version 4; reserved before
};
static_assert(sizeof(SpzHeader) == kSpzHeader && std::endian::native == std::endian::little);

// The arrays in the order of the file; bytes of each per splat.
enum SpzArray { kPositions, kAlphas, kColors, kScales, kRotations, kBands, kSpzArrayCount };
constexpr std::array<const char*, kSpzArrayCount> kSpzNames{
    "positions", "alphas", "colors", "scales", "rotations", "sh"};
std::array<size_t, kSpzArrayCount> WidthsOf(const SpzHeader& header) {
  return {header.version == 1 ? 6u : 9u,
          1,
          3,
          3,
          header.version >= 3 ? 4u : 3u,
          3 * size_t(CoefficientCount(header.degree) - 1)};
}

uint8_t RoundToByte(double x) { return uint8_t(std::clamp(std::round(x), 0.0, 255.0)); }

// Fixed point of 24 bits, little-endian.
void PutFixed(int32_t value, unsigned char* out) {
  for (int k = 0; k < 3; ++k) out[k] = uint8_t(uint32_t(value) >> 8 * k);
}
int32_t GetFixed(const unsigned char* in) {
  const uint32_t bits = uint32_t(in[0]) << 8 | uint32_t(in[1]) << 16 | uint32_t(in[2]) << 24;
  return int32_t(bits) >> 8;  // carries the sign down
}

// Versions 1 and 2: x, y and z, each -1..1 in a byte; w >= 0 follows.
void PackFirstThree(const std::array<double, 4>& wxyz, unsigned char* out) {
  std::array<double, 4> q = wxyz;
  NormalizeByLargest(q);
  const double sign = q[0] < 0 ? -1 : 1;
  for (int k = 0; k < 3; ++k) out[k] = RoundToByte(127.5 + 127.5 * sign * q[1 + k]);
}
void UnpackFirstThree(const unsigned char* in, float* wxyz) {
  double squares = 0;
  for (int k = 0; k < 3; ++k) {
    const double component = in[k] / 127.5 - 1;
    wxyz[1 + k] = float(component);
    squares += component * component;
  }
  wxyz[0] = float(LargestOf(squares));
}

// From version 3 on: of x, y, z, w (in this order) the index of the largest in 2 bits, then of each
// of the others a sign and 9 bits of magnitude, up to 1/sqrt(2).
constexpr uint32_t kMagnitude = (1 << 9) - 1;
void PackSmallestThree(const std::array<double, 4>& wxyz, unsigned char* out) {
  std::array<double, 4> q = wxyz;
  const int largest = (NormalizeByLargest(q) + 3) % 4;  // among x, y, z, w
  uint32_t bits = uint32_t(largest);
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const double component = q[(k + 1) % 4];
    const uint32_t magnitude =
        std::min(kMagnitude, uint32_t(std::lround(std::abs(component) / kSqrtHalf * kMagnitude)));
    bits = bits << 10 | uint32_t(component < 0) << 9 | magnitude;
  }
  std::memcpy(out, &bits, sizeof(bits));
}
void UnpackSmallestThree(const unsigned char* in, float* wxyz) {
  uint32_t bits;
  std::memcpy(&bits, in, sizeof(bits));
  const int largest = int(bits >> 30);
  double squares = 0;
  for (int k = 3; k >= 0; --k) {
    if (k == largest) continue;
    const double magnitude = kSqrtHalf * (bits & kMagnitude) / kMagnitude;
    wxyz[(k + 1) % 4] = float(bits >> 9 & 1 ? -magnitude : magnitude);
    squares += magnitude * magnitude;
    bits >>= 10;
  }
  wxyz[(largest + 1) % 4] = float(LargestOf(squares));
}

// A coefficient, -1..1, in a byte around 128, rounded to the nearest multiple of 256 / 2^bits.
uint8_t PackCoefficient(float value, int bits) {
  const int step = 1 << (8 - bits);
  return uint8_t(std::clamp<long>(
      std::lround(std::clamp(value, -2.f, 2.f) * 128 / step) * step + 128, 0, 255));
}

float CoefficientOf(uint8_t byte) { return (float(byte) - 128) / 128; }

// The number of fractional bits of the positions (spz.h).
int FractionalBits(const std::string& path, const Gaussians& g) {
  std::vector<float> smallest;
  double farthest = 0;
  size_t which = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* scale = g.at(kScaleLog, i);
    smallest.push_back(std::min({scale[0], scale[1], scale[2]}));
    for (int k = 0; k < 3; ++k)
      if (const double x = std::abs(g.at(kPosition, i)[k]); x > farthest) {
        farthest = x;
        which = i;
      }
  }
  constexpr double kStepOfSmallest = 1.0 / 16, kMaxBits = 24;
  const double wanted = std::ceil(-std::log2(kStepOfSmallest * std::exp(Median(smallest))));
  constexpr int32_t kLargestFixed = (1 << 23) - 1;
  const double fits = farthest > 0 ? std::floor(std::log2(kLargestFixed / farthest)) : kMaxBits;
  if (fits < 0)
    throw Error(path,
                "Gaussian " + std::to_string(which) + ", position",
                "is " + std::to_string(farthest) + " from the origin, SPZ reaches 8388607");
  return int(std::clamp(wanted, 0.0, std::min(fits, kMaxBits)));
}

void CheckForSpz(const std::string& path, const Gaussians& g, int version) {
  if (version < 2 || version > kLatestSpzVersion)
    throw Error(path, "version", "is " + std::to_string(version) + ", 2, 3 and 4 can be written");
  if (g.size() > std::numeric_limits<uint32_t>::max())
    throw Error(path, "numPoints", "is " + std::to_string(g.size()) + ", beyond 32 bits");
  CheckForSplatFile(path, g);
  // A few are nothing beside what the file rounds; a scene in another unit would be another scene.
  const auto fits = [](double scale_log) {
    return scale_log >= kLowestScaleLog && scale_log <= kLowestScaleLog + UINT8_MAX / kScaleSteps;
  };
  size_t beyond = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* s = g.at(kScaleLog, i);
    beyond += !fits(std::max({s[0], s[1], s[2]}));
  }
  if (beyond > g.size() / 100 + 1)
    throw Error(
        path,
        "scale",
        "of " + std::to_string(beyond) + " of " + std::to_string(g.size()) +
            " Gaussians is not 4.5e-5 to 380 units, which is all that SPZ holds: write .sog, "
            ".glb or .ply");
}

using SpzArrays = std::array<std::string, kSpzArrayCount>;

// SeenBands as of Gaussians turned to glTF's axes.
std::vector<float> Turned(View<const float> seen_bands, int degree) {
  const size_t width = size_t(CoefficientCount(degree) - 1);
  std::vector<float> turned;
  for (size_t k = 0; k < seen_bands.count; ++k)
    turned.push_back(seen_bands[k] * GltfTurnSign(1 + int(k % width)));
  return turned;
}

SpzArrays Pack(const Gaussians& g, View<const float> seen_bands, const SpzHeader& header) {
  const auto widths = WidthsOf(header);
  SpzArrays arrays;
  for (int a = 0; a < kSpzArrayCount; ++a) arrays[a].resize(widths[a] * g.size());
  const auto at = [&](SpzArray a, size_t i) {
    return reinterpret_cast<unsigned char*>(arrays[a].data()) + widths[a] * i;
  };
  std::vector<float> stored(widths[kBands]);
  for (size_t i = 0; i < g.size(); ++i) {
    for (size_t k = 0; k < stored.size(); ++k) {
      const uint8_t byte =
          PackCoefficient(g.at(kColorRest, i)[k], k < 9 ? kBitsOfBand1 : kBitsOfHigherBands);
      at(kBands, i)[k] = byte;
      stored[k] = CoefficientOf(byte);
    }
    std::array<float, 3> dc;
    std::copy_n(g.at(kColorDc, i), 3, dc.begin());
    if (seen_bands.count > 0)
      MoveErrorToDc(g.at(kColorRest, i),
                    stored.data(),
                    &seen_bands[stored.size() / 3 * i],
                    g.degree,
                    dc.data());
    for (int k = 0; k < 3; ++k) {
      PutFixed(int32_t(std::lround(std::ldexp(g.at(kPosition, i)[k], header.fractional_bits))),
               at(kPositions, i) + 3 * k);
      at(kColors, i)[k] = RoundToByte((kColorScale * dc[k] + 0.5) * 255);
      at(kScales, i)[k] = RoundToByte((g.at(kScaleLog, i)[k] - kLowestScaleLog) * kScaleSteps);
    }
    // Niantic's reader makes infinite logits of 0 and 255.
    *at(kAlphas, i) = std::clamp<uint8_t>(ByteOfLogit(*g.at(kOpacityLogit, i)), 1, 254);
    const float* r = g.at(kRotation, i);
    (header.version >= 3 ? PackSmallestThree : PackFirstThree)({r[0], r[1], r[2], r[3]},
                                                               at(kRotations, i));
  }
  return arrays;
}

std::string BytesOf(const SpzHeader& header) {
  return std::string(reinterpret_cast<const char*>(&header), sizeof(header));
}

// Version 4: header, offset of the table, 12 reserved bytes; per array its compressed and its plain
// size; the arrays. Empty arrays are left out.
std::string Container4(SpzHeader header, const SpzArrays& arrays) {
  std::string table, data;
  for (const std::string& array : arrays) {
    if (array.empty()) continue;
    const std::string packed = Zstd(array);
    const uint64_t sizes[2] = {packed.size(), array.size()};
    table.append(reinterpret_cast<const char*>(sizes), sizeof(sizes));
    data += packed;
    ++header.streams;
  }
  std::string bytes = BytesOf(header);
  const uint32_t offset = kHeaderOfVersion4;
  bytes.append(reinterpret_cast<const char*>(&offset), sizeof(offset));
  bytes.resize(kHeaderOfVersion4, '\0');
  return bytes + table + data;
}

SpzHeader CheckedHeader(const std::string& path, const unsigned char* bytes, size_t file_bytes) {
  SpzHeader header;
  std::memcpy(&header, bytes, sizeof(header));
  if (header.magic != kSpzMagic) throw Error(path, "is not an SPZ file");
  if (header.version < 1 || header.version > kLatestSpzVersion)
    throw Error(path, "version", "is " + std::to_string(header.version) + ", expected 1 to 4");
  if (header.degree > kMaxTrainedDegree)
    throw Error(path, "shDegree", "is " + std::to_string(header.degree) + ", expected 0 to 4");
  if (header.fractional_bits > 30)
    throw Error(
        path, "fractionalBits", Format("is {}, expected at most 30", header.fractional_bits));
  CheckSplatCount(path, "numPoints", header.count, file_bytes);
  return header;
}

using SpzBytes = std::array<std::vector<unsigned char>, kSpzArrayCount>;

SpzBytes ReadGzipped(const std::string& path, const std::vector<char>& file, SpzHeader& header) {
  GunzipReader reader(path, file);
  header = CheckedHeader(path, reader.Read("header", kSpzHeader).data(), file.size());
  if (header.version > 3)
    throw Error(path, "version", "is " + std::to_string(header.version) + " in a gzip file");
  const auto widths = WidthsOf(header);
  SpzBytes arrays;
  for (int a = 0; a < kSpzArrayCount; ++a)
    arrays[a] = reader.Read(kSpzNames[a], widths[a] * header.count);
  if ((header.flags & kSpzExtensions) == 0 && !reader.ReadUpTo(1).empty())
    throw Error(path,
                "header",
                Format("says version {}, {} splats of degree {}, which is less than the file has",
                       header.version,
                       header.count,
                       int(header.degree)));
  return arrays;
}

SpzBytes ReadVersion4(const std::string& path, const std::vector<char>& file, SpzHeader& header) {
  if (file.size() < kHeaderOfVersion4) throw Error(path, "header", "is truncated");
  header = CheckedHeader(path, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  if (header.version != 4)
    throw Error(path, "version", "is " + std::to_string(header.version) + ", but not gzipped");
  const auto widths = WidthsOf(header);
  size_t streams = 0;
  for (const size_t width : widths) streams += width * header.count > 0;
  if (header.streams != streams)
    throw Error(path, "numStreams", Format("is {}, expected {}", header.streams, streams));
  uint32_t offset;
  std::memcpy(&offset, &file[kSpzHeader], sizeof(offset));
  constexpr size_t kEntry = 16;
  if (offset < kHeaderOfVersion4 || offset > file.size() || file.size() - offset < kEntry * streams)
    throw Error(path, "tocByteOffset", "is " + std::to_string(offset) + ", beyond the file");
  const char* entry = &file[offset];
  size_t next = offset + kEntry * streams;
  SpzBytes arrays;
  for (int a = 0; a < kSpzArrayCount; ++a) {
    const size_t expected = widths[a] * header.count;
    if (expected == 0) continue;
    uint64_t sizes[2];
    std::memcpy(sizes, entry, sizeof(sizes));
    entry += kEntry;
    if (sizes[1] != expected)
      throw Error(path, kSpzNames[a], Format("has {} bytes, expected {}", sizes[1], expected));
    if (sizes[0] > file.size() - next) throw Error(path, kSpzNames[a], "is truncated");
    arrays[a] = Unzstd(path, kSpzNames[a], file.data() + next, sizes[0], expected);
    next += sizes[0];
  }
  return arrays;
}

void UnpackPosition(const std::string& path,
                    const SpzHeader& header,
                    const unsigned char* in,
                    size_t i,
                    float* out) {
  for (int k = 0; k < 3; ++k) {
    out[k] = header.version == 1
                 ? float(HalfToDouble(uint16_t(in[2 * k] | in[2 * k + 1] << 8)))
                 : float(std::ldexp(GetFixed(in + 3 * k), -int(header.fractional_bits)));
    if (!std::isfinite(out[k]))
      throw Error(path, "positions", "of splat " + std::to_string(i) + " is not finite");
  }
}

}  // namespace

void WriteSpz(const std::string& path,
              const Gaussians& gaussians,
              View<const float> seen_bands,
              int version) {
  CheckForSpz(path, gaussians, version);
  Gaussians turned = gaussians;
  TurnToGltfAxes(turned);
  HideWithoutRotation(turned);
  SpzHeader header;
  header.version = uint32_t(version);
  if (gaussians.antialiased)
    header.flags =
        kSpzAntialiased | (gaussians.low_pass_variance == kBlurVariance ? 0 : kSpzOurLowPass);
  header.count = uint32_t(turned.size());
  header.degree = uint8_t(turned.degree);
  header.fractional_bits = uint8_t(FractionalBits(path, turned));
  const SpzArrays arrays = Pack(turned, Turned(seen_bands, turned.degree), header);
  if (version == 4) return WriteFileAtomically(path, Container4(header, arrays));
  std::string bytes = BytesOf(header);
  for (const std::string& array : arrays) bytes += array;
  WriteFileAtomically(path, Gzip(bytes));
}

Gaussians ReadSpz(const std::string& path, std::vector<std::string>* notes) {
  const std::vector<char> file = ReadFile(path);
  SpzHeader header;
  const bool gzipped = file.size() >= 2 && file[0] == '\x1f' && file[1] == '\x8b';
  const SpzBytes arrays =
      gzipped ? ReadGzipped(path, file, header) : ReadVersion4(path, file, header);
  const auto widths = WidthsOf(header);
  Gaussians g;
  g.degree = header.degree;
  g.basis = Basis::kSh;
  g.antialiased = (header.flags & kSpzAntialiased) != 0;
  if (g.antialiased && (header.flags & kSpzOurLowPass) == 0) g.low_pass_variance = kBlurVariance;
  g.Resize(header.count);
  for (size_t i = 0; i < g.size(); ++i) {
    const auto at = [&](SpzArray a) { return arrays[a].data() + widths[a] * i; };
    UnpackPosition(path, header, at(kPositions), i, g.at(kPosition, i));
    for (int k = 0; k < 3; ++k) {
      g.at(kColorDc, i)[k] = float((at(kColors)[k] / 255.0 - 0.5) / kColorScale);
      g.at(kScaleLog, i)[k] = float(at(kScales)[k] / kScaleSteps + kLowestScaleLog);
    }
    *g.at(kOpacityLogit, i) = LogitOfByteShare(*at(kAlphas) / 255.0);
    (header.version >= 3 ? UnpackSmallestThree : UnpackFirstThree)(at(kRotations),
                                                                   g.at(kRotation, i));
    for (size_t k = 0; k < widths[kBands]; ++k)
      g.at(kColorRest, i)[k] = CoefficientOf(at(kBands)[k]);
  }
  TurnToGltfAxes(g);  // its own inverse
  if (notes && (header.flags & kSpzExtensions) != 0)
    notes->push_back("has extensions, which are not read: its axes may be others (Adobe's)");
  return g;
}

bool IsSpz(const std::string& path) { return FirstBytes(path, sizeof(kSpzMagic)) == "NGSP"; }

}  // namespace cosplat
