// Splat files of every layout, and points.
#include <cstring>

#include "splat/base/compression.h"
#include "splat/base/files.h"
#include "splat/io/color_weights.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_file.h"
#include "splat/io/spz.h"
#include "splat/levels/level_renderer.h"
#include "splat/levels/levels_file.h"
#include "tests/fuzz/reader.h"
#include "tests/splat/ply_packer.h"
#include "tests/support/glb_bytes.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

using Strings = std::vector<std::string>;

const Gaussians& SeedGaussians() {
  static const Gaussians gaussians = RandomGaussians(30, 1, Basis::kSh, 1);
  return gaussians;
}

std::string SplatProblem(const Gaussians& g, size_t bytes) {
  for (const auto& values : g.values)
    if (const std::string problem = NotFinite(values); !problem.empty()) return problem;
  // A deflated run of equal splats may be a thousandth of them.
  return g.size() > 1100 * bytes + (1 << 16) ? "more splats than bytes" : "";
}

// What a writer leaves under this name.
std::string Written(const char* name, const std::function<void(const std::string&)>& write) {
  const TemporaryFolder folder;
  write(folder / name);
  return Slurped(folder / name);
}

// The checksums are made right, so that what they are of is read.
void MendLevels(std::string& bytes) {
  constexpr size_t kHeader = 32, kBlock = 32;
  if (bytes.size() < kHeader) return;
  uint32_t degree = 0;
  uint64_t gaussians = 0;
  std::memcpy(&degree, bytes.data() + 12, sizeof degree);
  std::memcpy(&gaussians, bytes.data() + kHeader - sizeof gaussians, sizeof gaussians);
  SceneLevels levels;
  levels.layout.degree = int(std::min(degree, 4u));
  if (gaussians > bytes.size() / (levels.width() * sizeof(float))) return;
  const uint64_t floats = levels.LayOut(gaussians);
  const size_t table = kHeader + levels.blocks.size() * kBlock;
  const size_t begin = (table + 4 + 63) / 64 * 64;
  if (bytes.size() < begin + floats * sizeof(float)) return;
  for (size_t b = 0; b < levels.blocks.size(); ++b) {
    const uint32_t crc = Crc32(bytes.data() + begin + levels.offsets[b] * sizeof(float),
                               levels.blocks[b].count * levels.width() * sizeof(float));
    std::memcpy(bytes.data() + kHeader + (b + 1) * kBlock - sizeof crc, &crc, sizeof crc);
  }
  const uint32_t crc = Crc32(bytes.data(), table);
  std::memcpy(bytes.data() + table, &crc, sizeof crc);
}

std::string LevelsProblem(const std::string& folder, std::string bytes) {
  MendLevels(bytes);
  WriteFileAtomically(folder + "/a.levels", bytes);
  LevelRenderer renderer(OpenLevels(folder + "/a.levels"));
  Camera camera;
  camera.width = camera.height = 8;
  camera.fx = camera.fy = 8;
  camera.cx = camera.cy = 4;
  camera.translation = {0, 0, 3};
  RenderedImage image;
  for (const LevelLimits& limits : {LevelLimits{0}, LevelLimits{0, 1}}) {
    renderer.Draw(camera, {{0, 0, 0}, renderer.levels().layout.degree}, limits, image);
    if (const std::string problem = NotFinite(image.color); !problem.empty()) return problem;
  }
  return "";
}

Strings LevelsSeeds() {
  Gaussians antialiased = RandomGaussians(1100, 1, Basis::kSh, 2);
  antialiased.antialiased = true;
  Strings seeds;
  for (const Gaussians& g : {RandomGaussians(1500, 0, Basis::kSh, 1), antialiased})
    seeds.push_back(
        Written("a.levels", [&](const std::string& path) { WriteLevels(path, BuildLevels(g)); }));
  return seeds;
}

FuzzedReader SplatFile(const char* name,
                       const char* file,
                       const std::function<Strings()>& seeds,
                       const Strings& words,
                       Placing placing = Placing::kFiles) {
  const auto read = [file](const std::string& folder, const std::string& bytes) {
    return SplatProblem(ReadSplats(folder + "/" + file), bytes.size());
  };
  return {name, placing, {file}, read, seeds, words};
}

Strings PlySeeds() {
  Strings seeds;
  for (int degree : {0, 1, 3})
    seeds.push_back(Written("a.ply", [&](const std::string& path) {
      WritePly(path, RandomGaussians(6, degree, Basis::kSh, 1));
    }));
  return seeds;
}

Strings CompressedPlySeeds() {
  return {PackedFile(RandomSplats(9), {}),
          PackedFile(RandomSplats(300), {false, 9}),
          PackedFile(RandomSplats(3), {true, 45})};
}

Strings PointSeeds() {
  return {Written("a.ply", [](const std::string& path) {
    WritePointsPly(path, {1, 2, 3, -4, 5, 6}, {1, 2, 3, 40, 50, 60});
  })};
}

Strings SpzSeeds() {
  Strings seeds;
  for (int version : {2, 3, 4})
    seeds.push_back(Written(
        "a.spz", [&](const std::string& path) { WriteSpz(path, SeedGaussians(), {}, version); }));
  return seeds;
}

Strings SpzPlainSeeds() {
  Strings seeds;
  for (int version : {2, 3}) {
    const std::string packed = Written(
        "a.spz", [&](const std::string& path) { WriteSpz(path, SeedGaussians(), {}, version); });
    // A header of 16 bytes, then 20 (version 3) or 19 per splat and 9 for the first band.
    const std::vector<char> bytes(packed.begin(), packed.end());
    const auto plain = GunzipReader("seed", bytes).Read("all", 16 + 30 * (version == 3 ? 29 : 28));
    seeds.emplace_back(plain.begin(), plain.end());
  }
  return seeds;
}

std::string SogBundle(const TemporaryFolder& folder) {
  WriteSog(folder / "a.sog", SeedGaussians(), SizeSignificance(SeedGaussians()), {});
  return folder / "a.sog";
}

Strings RecordSeeds() {
  std::string records;
  for (int i = 0; i < 8; ++i) {
    const float numbers[6] = {float(i), 1, -2, 0.1f, 0.2f, 0.3f};
    records.append(reinterpret_cast<const char*>(numbers), sizeof(numbers));
    records += "\x10\x80\xf0\xc0\xff\x80\x60\x90";
  }
  return {records};
}

std::string SceneGlb() {
  return Written("a.glb", [](const std::string& path) { WriteSceneGlb(path, SeedGaussians()); });
}

std::string ReadPoints(const std::string& folder, const std::string&) {
  std::vector<double> points;
  std::vector<uint8_t> colors;
  ReadPointsPly(folder + "/p.ply", points, colors);
  return points.size() == colors.size() ? NotFinite(points) : "points without colours";
}

}  // namespace

std::vector<FuzzedReader> SplatReaders() {
  const Strings ply = {"ply\n",
                       "format binary_little_endian 1.0\n",
                       "end_header\n",
                       "element vertex 1\n",
                       "element chunk 1\n",
                       "element sh 1\n",
                       "property float ",
                       "property uchar ",
                       "property list uchar int ",
                       "f_rest_0\n",
                       "opacity\n",
                       "packed_position\n"};
  const Strings glb = {"KHR_gaussian_splatting",
                       "accessors",
                       "bufferViews",
                       "byteOffset",
                       "byteStride",
                       "componentType",
                       "attributes",
                       "POSITION",
                       "sparse",
                       "KHR_gaussian_splatting:ROTATION",
                       "extensionsRequired",
                       "uri"};
  const Strings sog = {"meta.json", "means_l.webp", "codebook", "mins", "maxs", "count", "shN"};
  std::vector<FuzzedReader> readers;
  readers.push_back(SplatFile("ply", "a.ply", PlySeeds, ply));
  readers.push_back(SplatFile("ply_gz", "a.ply", PlySeeds, ply, Placing::kGzip));
  readers.push_back(SplatFile("compressed_ply", "a.ply", CompressedPlySeeds, ply));
  readers.push_back({"points_ply", Placing::kFiles, {"p.ply"}, ReadPoints, PointSeeds, ply});
  readers.push_back(SplatFile("spz", "a.spz", SpzSeeds, {"NGSP", "\x1f\x8b"}));
  readers.push_back(SplatFile("spz_plain", "a.spz", SpzPlainSeeds, {"NGSP"}, Placing::kGzip));
  readers.push_back(SplatFile(
      "sog", "a.sog", [] { return Strings{Slurped(SogBundle(TemporaryFolder()))}; }, {"PK\1\2"}));
  readers.push_back(SplatFile(
      "sog_members",
      "a.sog",
      [] { return Strings{PartsOfZip(SogBundle(TemporaryFolder()))}; },
      sog,
      Placing::kZip));
  readers.push_back(SplatFile("splat", "a.splat", RecordSeeds, {}));
  readers.push_back(
      {"levels", Placing::kFiles, {"a.levels"}, LevelsProblem, LevelsSeeds, {"COSPLOD\n"}});
  readers.push_back(SplatFile(
      "glb", "a.glb", [] { return Strings{SceneGlb()}; }, glb));
  readers.push_back(SplatFile(
      "glb_chunks",
      "a.glb",
      [] {
        const GlbBytes parts = SplitGlb(SceneGlb());
        return Strings{JoinParts({parts.json.dump(), parts.binary})};
      },
      glb,
      Placing::kGlb));
  return readers;
}

}  // namespace cosplat::test
