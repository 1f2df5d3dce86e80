// Scenes as .glb, and what the reader says of damaged and hostile files.
#include "splat/io/glb.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/splat_file.h"
#include "splat/io/splat_primitive.h"
#include "tests/support/glb_bytes.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/splat_attributes.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using nlohmann::json;
using test::RandomGaussians;

const std::vector<std::string> kKnown{"KHR_gaussian_splatting"};

std::string Slurp(const std::string& path) {
  const auto bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

// what() of the Error that `run` throws; empty when it throws none.
std::string ErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

class GlbTest : public testing::Test {
 protected:
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_ / "scene.glb";

  // A valid file: 3 Gaussians of degree 1.
  std::string ValidBytes() {
    WriteSceneGlb(path_, RandomGaussians(3, 1, Basis::kDcsh, 1));
    return Slurp(path_);
  }
  GlbDocument Parse(const std::string& bytes) {
    return ParseGlb(path_, {bytes.begin(), bytes.end()}, kKnown);
  }
  std::string ReadError(const std::string& bytes) {
    return ErrorOf([&] { Parse(bytes); });
  }
};

TEST_F(GlbTest, ASceneShowsTheSameImageInOtherPrograms) {
  Camera camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 70;
  camera.cx = camera.cy = 32;
  camera.translation = {0.1f, -0.05f, 3};
  for (Basis basis : test::kHarmonicBases)
    for (int degree = 0; degree <= 3; ++degree) {
      const Gaussians scene = RandomGaussians(150, degree, basis, 5 + degree);
      WriteSceneGlb(path_, scene);
      const GlbDocument document = ReadGlb(path_, kKnown);
      EXPECT_EQ(document.extensions_used, kKnown);
      Gaussians read = test::DecodeSplats(document, document.meshes.at(0).primitives.at(0));
      EXPECT_EQ(read.degree, degree);
      TurnToGltfAxes(read);  // its own inverse
      // Through log and exponential of scale and opacity: measured 5e-7.
      EXPECT_LT(test::LargestDifference(test::Image(scene, camera), test::Image(read, camera)),
                1e-5);
    }
}

TEST_F(GlbTest, WhatStandsInTheFile) {
  const json j = test::SplitGlb(ValidBytes()).json;
  const json& primitive = j["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["mode"], 0);
  EXPECT_EQ(primitive["extensions"]["KHR_gaussian_splatting"],
            json({{"kernel", "ellipse"},
                  {"colorSpace", "srgb_rec709_display"},
                  {"projection", "perspective"},
                  {"sortingMethod", "cameraDistance"}}));
  EXPECT_EQ(j["extensionsUsed"], json({"KHR_gaussian_splatting"}));
  EXPECT_FALSE(j.contains("extensionsRequired"));
  const json& position = j["accessors"][primitive["attributes"]["POSITION"].get<int>()];
  EXPECT_EQ(position["min"].size(), 3u);
  EXPECT_EQ(position["max"].size(), 3u);
  EXPECT_EQ(primitive["attributes"].size(), 4u + 4u);
  EXPECT_TRUE(primitive["attributes"].contains("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2"));
}

TEST_F(GlbTest, DegreeFourOnlyWhenToldToTruncate) {
  const Gaussians scene = RandomGaussians(10, 4, Basis::kDcsh, 6);
  EXPECT_NE(ErrorOf([&] { WriteSceneGlb(path_, scene); }).find("degree"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path_));
  WriteSceneGlb(path_, scene, true);
  const GlbDocument document = ReadGlb(path_, kKnown);
  const Gaussians read = test::DecodeSplats(document, document.meshes[0].primitives[0]);
  EXPECT_EQ(read.degree, 3);
}

TEST_F(GlbTest, NumbersThatAreNotFiniteAreNotWritten) {
  const auto spoil = [&](int attribute, float value) {
    Gaussians scene = RandomGaussians(4, 1, Basis::kSh, 7);
    scene.values[attribute][scene.width(attribute) * 2] = value;
    return ErrorOf([&] { WriteSceneGlb(path_, scene); });
  };
  for (int attribute = 0; attribute <= kColorRest; ++attribute)  // a scene has no corrections
    EXPECT_NE(spoil(attribute, NAN).find("Gaussian 2"), std::string::npos) << attribute;
  EXPECT_NE(spoil(kScaleLog, 100).find("SCALE"), std::string::npos);  // e^100 is no float
  EXPECT_NE(ErrorOf([&] { WriteSceneGlb(path_, Gaussians()); }), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(GlbTest, AFileThatCannotBeWrittenNamesIt) {
  const std::string path = folder_ / "no_folder/scene.glb";
  const std::string error =
      ErrorOf([&] { WriteSceneGlb(path, RandomGaussians(1, 0, Basis::kSh, 1)); });
  EXPECT_NE(error.find(path), std::string::npos) << error;
}

TEST_F(GlbTest, AFileCutAnywhereIsAnError) {
  const std::string bytes = ValidBytes();
  for (size_t size = 0; size < bytes.size(); ++size)
    ASSERT_NE(ReadError(bytes.substr(0, size)), "") << "cut at " << size;
  // The same with a header that agrees with the shorter file.
  for (size_t size = 12; size < bytes.size(); ++size) {
    std::string cut = bytes.substr(0, size);
    cut.replace(8, 4, test::Bytes32(uint32_t(size)));
    ASSERT_NE(ReadError(cut), "") << "cut at " << size;
  }
}

TEST_F(GlbTest, RandomDamageNeverCrashes) {
  const std::string bytes = ValidBytes();
  Rng rng{8};
  int refused = 0;
  for (int round = 0; round < 4000; ++round) {
    std::string damaged = bytes;
    const int flips = 1 + int(rng.Next() % 4);
    for (int i = 0; i < flips; ++i) damaged[rng.Next() % damaged.size()] = char(rng.Next() % 256);
    // Error or a document: anything else ends the test.
    const std::string error = ReadError(damaged);
    refused += !error.empty();
    EXPECT_TRUE(error.empty() || error.find(path_) == 0) << error;
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 4000);
}

TEST_F(GlbTest, HostileJsonIsAnErrorThatNamesTheField) {
  const test::GlbBytes valid = test::SplitGlb(ValidBytes());
  struct Case {
    const char* pointer;
    json value;
    const char* named;
  };
  const std::vector<Case> cases{
      {"/accessors/0/count", 1000000, "accessors[0].count"},
      {"/accessors/0/count", 4294967295u, "accessors[0].count"},
      {"/accessors/0/count", 18446744073709551615ull, "accessors[0].count"},
      {"/accessors/0/count", 0, "accessors[0].count"},
      {"/accessors/0/count", -1, "accessors[0].count"},
      {"/accessors/0/count", "3", "accessors[0].count"},
      {"/accessors/0/count", 2.5, "accessors[0].count"},
      {"/accessors/0/type", "VEC4", "accessors[0].count"},
      {"/accessors/0/type", "MAT4", "accessors[0].type"},
      {"/accessors/0/type", 3, "accessors[0].type"},
      {"/accessors/0/componentType", 5124, "accessors[0].componentType"},
      {"/accessors/0/componentType", -5126, "accessors[0].componentType"},
      {"/accessors/0/bufferView", 99, "accessors[0].bufferView"},
      {"/accessors/0/bufferView", -1, "accessors[0].bufferView"},
      {"/accessors/0/byteOffset", -12, "accessors[0].byteOffset"},
      {"/accessors/0/byteOffset", 4, "accessors[0].count"},
      {"/accessors/0/byteOffset", 1, "accessors[0]"},
      {"/accessors/0/sparse", json::object(), "accessors[0].sparse"},
      {"/accessors/0", 7, "accessors[0]"},
      {"/accessors", json::object(), "accessors"},
      {"/bufferViews/1/byteOffset", 4294967295u, "bufferViews[1].byteOffset"},
      {"/bufferViews/1/byteOffset", -4, "bufferViews[1].byteOffset"},
      {"/bufferViews/1/byteLength", 4294967295u, "bufferViews[1].byteLength"},
      {"/bufferViews/1/byteStride", 2, "bufferViews[1].byteStride"},
      {"/bufferViews/1/byteStride", 6, "bufferViews[1].byteStride"},
      {"/bufferViews/1/byteStride", 8, "accessors[1]"},
      {"/bufferViews/1/buffer", 1, "bufferViews[1].buffer"},
      {"/bufferViews/1", nullptr, "bufferViews[1]"},
      {"/bufferViews", json::array(), "accessors[0]"},
      {"/buffers/0/byteLength", 4294967295u, "buffers[0].byteLength"},
      {"/buffers/0/byteLength", 0, "buffers[0].byteLength"},
      {"/buffers/0/uri", "../../etc/passwd", "buffers[0].uri"},
      {"/buffers/0/uri", "/etc/passwd", "buffers[0].uri"},
      {"/buffers/0/uri", "data:application/octet-stream;base64,AAAA", "buffers[0].uri"},
      {"/buffers/1", {{"byteLength", 4}}, "buffers[1]"},
      {"/images", {{{"uri", "../secret.png"}}}, "images[0].uri"},
      {"/extensionsRequired", {"EXT_meshopt_compression"}, "extensionsRequired[0]"},
      {"/asset/version", "1.0", "asset.version"},
      {"/asset", 2, "asset"},
  };
  for (const Case& c : cases) {
    test::GlbBytes glb = valid;
    glb.json[json::json_pointer(c.pointer)] = c.value;
    const std::string error = ReadError(test::JoinGlb(glb));
    EXPECT_NE(error.find(c.named), std::string::npos) << c.pointer << " said: " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST_F(GlbTest, AnyMemberReplacedByAnythingNeverCrashes) {
  const test::GlbBytes valid = test::SplitGlb(ValidBytes());
  const json flat = valid.json.flatten();
  const std::vector<json> replacements{nullptr,
                                       -1,
                                       1e300,
                                       4294967296ll,
                                       1 << 30,
                                       "x",
                                       true,
                                       "..",
                                       {},
                                       json::array(),
                                       json::object(),
                                       {{"a", 1}}};
  std::vector<std::string> pointers;
  for (const auto& [pointer, value] : flat.items()) {
    // The member itself and everything that it stands in.
    for (size_t end = pointer.size(); end != std::string::npos && end > 0;
         end = pointer.rfind('/', end - 1))
      pointers.push_back(pointer.substr(0, end));
  }
  size_t refused = 0;
  for (const std::string& pointer : pointers)
    for (const json& replacement : replacements) {
      test::GlbBytes glb = valid;
      glb.json[json::json_pointer(pointer)] = replacement;
      const std::string error = ErrorOf([&] {
        const GlbDocument document = Parse(test::JoinGlb(glb));
        for (const GlbMesh& mesh : document.meshes)
          for (const GlbPrimitive& primitive : mesh.primitives)
            for (const auto& [name, accessor] : primitive.attributes)
              ReadValues<float>(document, accessor, 3, name);
      });
      refused += !error.empty();
      EXPECT_TRUE(error.empty() || error.find(path_) == 0) << error;
    }
  EXPECT_GT(refused, 0u);
  EXPECT_LT(refused, pointers.size() * replacements.size());
}

TEST_F(GlbTest, DeepNestingIsRefused) {
  for (const char* open : {"[", "{\"a\":"}) {
    std::string text;
    for (int i = 0; i < 100000; ++i) text += open;
    EXPECT_NE(ReadError(test::JoinGlb(text, "....")).find("nested"), std::string::npos);
  }
}

TEST_F(GlbTest, NotGlbAtAll) {
  EXPECT_NE(ErrorOf([&] { ReadGlb(folder_ / "absent.glb", kKnown); }).find("absent.glb"),
            std::string::npos);
  EXPECT_NE(ReadError("ply\nformat ascii 1.0\nend_header\n"), "");
  EXPECT_NE(ReadError(""), "");
  EXPECT_NE(ReadError(test::JoinGlb("{\"asset\":{\"version\":\"2.0\"}", "....")).find("JSON"),
            std::string::npos);
}

TEST_F(GlbTest, ValuesThatAreNotFiniteAreNotRead) {
  test::GlbBytes glb = test::SplitGlb(ValidBytes());
  const float nan = NAN;
  std::memcpy(glb.binary.data() + 12, &nan, sizeof(nan));
  const GlbDocument document = Parse(test::JoinGlb(glb));
  const std::string error = ErrorOf([&] { ReadValues<float>(document, 0, 3, "POSITION"); });
  EXPECT_NE(error.find("POSITION: element 1"), std::string::npos) << error;
}

}  // namespace
}  // namespace cosplat
