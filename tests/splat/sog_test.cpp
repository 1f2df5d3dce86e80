// PlayCanvas' SOG: files of our own read back, as a bundle and as a folder, and what is wrong with
// bad ones.
#include "splat/io/sog.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/zip_archive.h"
#include "splat/io/color_weights.h"
#include "splat/io/splat_file.h"
#include "splat/media/webp.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;
using test::ExpectError;
using test::TemporaryFolder;

std::string Text(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

Camera FrontCamera() {
  Camera camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 60;
  camera.cx = camera.cy = 32;
  camera.translation = {0.1f, -0.05f, 3};
  return camera;
}

void Write(const std::string& path, const Gaussians& g, const SogSettings& settings = {}) {
  WriteSog(path, g, SizeSignificance(g), settings);
}

// The nearest of the Gaussians read, by position: the file has them in another order.
size_t NearestTo(const Gaussians& read, const float* position) {
  size_t nearest = 0;
  float best = INFINITY;
  for (size_t i = 0; i < read.size(); ++i) {
    float distance = 0;
    for (int k = 0; k < 3; ++k) distance += std::abs(read.at(kPosition, i)[k] - position[k]);
    if (distance < best) {
      best = distance;
      nearest = i;
    }
  }
  return nearest;
}

// Fewer Gaussians than entries of every codebook: only the bytes and the 16 bits round.
TEST(Sog, ReadsBackWithinItsSteps) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    SCOPED_TRACE(degree);
    const Gaussians g = test::RandomGaussians(80, degree, Basis::kSh, 1);
    Write(folder / "a.sog", g);
    ASSERT_EQ(SplatLayoutOf(folder / "a.sog"), SplatLayout::kSog);
    const Gaussians read = ReadSog(folder / "a.sog");
    ASSERT_EQ(read.size(), g.size());
    EXPECT_EQ(read.degree, degree);
    for (size_t i = 0; i < g.size(); ++i) {
      const size_t j = NearestTo(read, g.at(kPosition, i));
      float dot = 0, norm = 0;
      for (int k = 0; k < 4; ++k) {
        dot += read.at(kRotation, j)[k] * g.at(kRotation, i)[k];
        norm += g.at(kRotation, i)[k] * g.at(kRotation, i)[k];
      }
      EXPECT_GT(std::abs(dot) / std::sqrt(norm), 0.9999f);
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(read.at(kPosition, j)[k], g.at(kPosition, i)[k], 1e-4f);
        // 240 numbers, of which k-means lets close ones share an entry: 4e-4 was measured.
        EXPECT_NEAR(read.at(kScaleLog, j)[k], g.at(kScaleLog, i)[k], 2e-3f);
        EXPECT_NEAR(read.at(kColorDc, j)[k], g.at(kColorDc, i)[k], 2e-3f);
      }
      // The palette holds every Gaussian's bands; its numbers share a codebook of 256, sparse at
      // the ends: 0.075 was measured.
      for (int k = 0; k < g.width(kColorRest); ++k)
        EXPECT_NEAR(read.at(kColorRest, j)[k], g.at(kColorRest, i)[k], 0.1f);
    }
  }
}

TEST(Sog, ShowsTheSameImage) {
  const TemporaryFolder folder;
  const Gaussians g = test::RandomGaussians(200, 3, Basis::kSh, 3);
  Write(folder / "a.sog", g);
  const RenderedImage image = test::Image(g, FrontCamera());
  EXPECT_LT(
      test::LargestDifference(test::Image(ReadSplats(folder / "a.sog"), FrontCamera()), image),
      0.03f);  // 0.016 was measured
  // A folder is the same file.
  fs::create_directory(folder / "b");
  Write(folder / "b/meta.json", g);
  for (const char* path : {"b", "b/meta.json"})
    EXPECT_EQ(ReadSplats(folder / path).values, ReadSog(folder / "a.sog").values);
  EXPECT_EQ(SplatLayoutOf(folder / "b"), SplatLayout::kSog);
  EXPECT_EQ(SplatLayoutOf(folder.path()), SplatLayout::kNone);
}

TEST(Sog, IsTheSameForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const Gaussians g = test::RandomGaussians(2000, 2, Basis::kSh, 4);
  Write(folder / "a.sog", g, {{}, 64, 1});
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    Write(folder / "b.sog", g, {{}, 64, 1});
  }
  EXPECT_EQ(Text(folder / "a.sog"), Text(folder / "b.sog"));
  Write(folder / "c.sog", g, {{}, 64, 2});
  EXPECT_NE(Text(folder / "a.sog"), Text(folder / "c.sog"));
}

// The members of a bundle, to be changed and written again.
struct Members {
  explicit Members(const std::string& path) {
    const ZipReader zip(path, "SOG");
    for (size_t i = 0; i < zip.size(); ++i) {
      const std::vector<char> bytes = zip.Read(i);
      all.push_back({zip.Name(i), {bytes.begin(), bytes.end()}});
    }
  }
  std::string& operator[](const std::string& name) {
    return std::find_if(all.begin(), all.end(), [&](const ZipMember& m) { return m.name == name; })
        ->bytes;
  }
  void ChangeMeta(const std::function<void(Json&)>& change) {
    Json meta = Json::parse((*this)["meta.json"]);
    change(meta);
    (*this)["meta.json"] = meta.dump();
  }
  std::vector<ZipMember> all;
};

Image8 FlatImage(int width, int height, uint8_t value) { return {width, height, 4, value}; }

TEST(Sog, BadFilesSayWhatIsWrong) {
  const TemporaryFolder folder;
  Write(folder / "a.sog", test::RandomGaussians(40, 1, Basis::kSh, 5));
  const auto meta = [](const std::function<void(Json&)>& change) {
    return [=](Members& members) { members.ChangeMeta(change); };
  };
  const struct {
    std::function<void(Members&)> change;
    std::vector<std::string> parts;
  } cases[] = {
      {meta([](Json& m) { m["version"] = 1; }), {"version", "1"}},
      {meta([](Json& m) { m.erase("count"); }), {"count", "missing"}},
      {meta([](Json& m) { m["count"] = -3; }), {"count", "-3"}},
      {meta([](Json& m) { m["count"] = 2'000'000'000; }), {"count", "bytes can hold"}},
      {meta([](Json& m) { m["count"] = 60'000; }), {"means_l.webp", "too few", "60000"}},
      {meta([](Json& m) {
         m["means"]["mins"] = {0, 1};
       }),
       {"means.mins", "expected 3"}},
      {meta([](Json& m) { m["means"]["maxs"][1] = -1000; }), {"means.mins", "maxs -1000"}},
      {meta([](Json& m) { m["means"]["maxs"][0] = 1000; }), {"means", "range"}},
      {meta([](Json& m) { m["scales"]["codebook"][7] = nullptr; }), {"scales.codebook[7]"}},
      {meta([](Json& m) { m["sh0"]["codebook"].erase(0); }), {"sh0.codebook", "expected 256"}},
      {meta([](Json& m) { m["shN"]["bands"] = 4; }), {"shN.bands", "4"}},
      {meta([](Json& m) { m["shN"]["count"] = 2; }), {"shN_labels.webp", "palette has 2"}},
      {meta([](Json& m) { m["shN"]["count"] = 70'000; }), {"shN.count", "70000"}},
      {meta([](Json& m) { m["quats"]["files"][0] = "../../x"; }), {"files", "'../../x'"}},
      {meta([](Json& m) { m["quats"]["files"][0] = "none.webp"; }), {"none.webp", "missing"}},
      {[](Members& m) { m["meta.json"] = "{"; }, {"meta.json", "not valid JSON"}},
      {[](Members& m) { m["meta.json"] = std::string(2 << 20, ' '); }, {"meta.json", "at most"}},
      {[](Members& m) { m["sh0.webp"].resize(40); }, {"sh0.webp", "truncated"}},
      {[](Members& m) { m["sh0.webp"].resize(m["sh0.webp"].size() - 30); }, {"sh0.webp"}},
      {[](Members& m) { m["sh0.webp"] = "\x89PNG"; }, {"sh0.webp", "not a WebP image"}},
      {[](Members& m) { m["quats.webp"] = EncodeWebp("", "", FlatImage(8, 8, 7)); },
       {"quats.webp", "splat 0", "7", "252 to 255"}},
      {[](Members& m) { m["scales.webp"] = EncodeWebp("", "", FlatImage(4, 4, 7)); },
       {"scales.webp", "4x4", "too few"}},
      // A picture of a gigabyte in some hundred bytes.
      {[](Members& m) { m["sh0.webp"] = EncodeWebp("", "", FlatImage(4096, 4096, 7)); },
       {"sh0.webp", "4096x4096", "at most"}},
      {[](Members& m) { m["sh0.webp"] = std::string(64 << 20, '\0'); }, {"sh0.webp", "at most"}}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.parts[0]);
    Members members(folder / "a.sog");
    c.change(members);
    WriteZip(folder / "bad.sog", members.all);
    ExpectError([&] { ReadSplats(folder / "bad.sog"); }, c.parts);
  }
}

TEST(Sog, TruncatedFilesAreRefused) {
  const TemporaryFolder folder;
  Write(folder / "a.sog", test::RandomGaussians(40, 1, Basis::kSh, 5));
  const std::string whole = Text(folder / "a.sog");
  for (size_t cut = 0; cut < whole.size(); cut += 97) {
    WriteFileAtomically(folder / "cut.sog", whole.substr(0, cut));
    ExpectError([&] { ReadSplats(folder / "cut.sog"); }, {"cut.sog"});
  }
}

TEST(Sog, RefusesWhatItCannotHold) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::function<void(Gaussians&)>& change,
                          const std::vector<std::string>& parts,
                          int palette = 16) {
    Gaussians g = test::RandomGaussians(3, 1, Basis::kSh, 7);
    change(g);
    ExpectError([&] { Write(folder / "no.sog", g, {{}, palette, 0}); }, parts);
    EXPECT_FALSE(fs::exists(folder / "no.sog"));
  };
  refuse([](Gaussians& g) { g.basis = Basis::kDcsh; }, {"no.sog", "basis", "dcsh"});
  refuse([](Gaussians& g) { g.Resize(0); }, {"no Gaussians"});
  refuse([](Gaussians& g) { g.at(kColorDc, 1)[2] = NAN; }, {"Gaussian 1, color_dc", "finite"});
  refuse([](Gaussians& g) { g = test::RandomGaussians(3, 4, Basis::kSh, 7); }, {"degree", "4"});
  refuse([](Gaussians&) {}, {"palette", "65537"}, 65537);
}

TEST(Webp, KeepsEveryByte) {
  Image8 image(37, 19, 4);
  Rng rng{3};
  for (uint8_t& byte : image.data) byte = uint8_t(rng.Below(256));
  for (size_t i = 3; i < image.data.size(); i += 8) image.data[i] = 0;  // transparent
  const std::string bytes = EncodeWebp("a", "b", image);
  const Image8 read = DecodeWebp("a", "b", {bytes.begin(), bytes.end()}, image.pixels());
  EXPECT_EQ(read.data, image.data);
  EXPECT_EQ(EncodeWebp("a", "b", image), bytes);
  ExpectError([&] { EncodeWebp("a", "b", Image8(16384, 1, 4)); }, {"a", "b", "16384x1"});
}

}  // namespace
}  // namespace cosplat
