// Avatars as .glb: round trip, what other programs see, licences, golden bytes, bad input.
#include "avatar/io/avatar_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <tuple>

#include "avatar/io/binding_extension.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/surface.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/splat_primitive.h"
#include "tests/avatar/meshes.h"
#include "tests/avatar/with_corrections.h"
#include "tests/flame/random_model.h"
#include "tests/support/glb_bytes.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/splat_attributes.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using nlohmann::json;

const std::string kHash(64, 'a');

// A model whose template is a ball; not redistributable.
FlameModel BallFlame() {
  const CanonicalMesh ball = test::SphereMesh(2, 0.1f);
  FlameModel flame = test::RandomModel(int(ball.vertices.size() / 3), 3, 4, 1);
  flame.name = "ball.npz";
  flame.sha256 = kHash;
  flame.template_vertices = ball.vertices;
  flame.faces = ball.faces;
  for (auto* directions : {&flame.shape_directions, &flame.expression_directions})
    for (float& x : *directions) x *= 0.02f;
  return flame;
}

// An avatar of that model with every field filled.
AvatarModel BallAvatar(const FlameModel& flame, size_t n, int degree, Basis basis) {
  AvatarModel model;
  model.flame_name = flame.name;
  model.flame_sha256 = flame.sha256;
  model.shape = {0.5f, -0.25f};
  model.static_offset.assign(3 * flame.vertex_count, 0);
  for (size_t i = 0; i < model.static_offset.size(); ++i)
    model.static_offset[i] = 1e-4f * float(int(i % 7) - 3);
  AttachMesh(model, flame);
  const AvatarModel embedded = test::RandomAvatar(model.mesh, n, 3);
  model.embedding.triangle = embedded.embedding.triangle;
  model.embedding.barycentric = embedded.embedding.barycentric;
  model.gaussians = test::RandomGaussians(n, degree, basis, 4);
  for (int a : {kPosition, kRotation}) model.gaussians.values[a] = embedded.gaussians.values[a];
  for (size_t i = 0; i < n; ++i) model.gaussians.at(kPosition, i)[2] *= 0.1f;
  for (float& x : model.gaussians.values[kScaleLog]) x -= 2;
  model.background = {0.1f, 0.2f, 0.3f};
  return model;
}

template <class A, class B>
void ExpectSameBits(const A& a, const B& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  if (!a.empty()) {
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(*a.data())), 0) << what;
  }
}

void ExpectSameAvatar(const AvatarModel& a, const AvatarModel& b) {
  EXPECT_EQ(a.gaussians.degree, b.gaussians.degree);
  EXPECT_EQ(a.gaussians.basis, b.gaussians.basis);
  for (int i = 0; i < kAttributeCount; ++i)
    ExpectSameBits(a.gaussians.values[i], b.gaussians.values[i], "attribute " + std::to_string(i));
  ExpectSameBits(a.embedding.triangle, b.embedding.triangle, "triangle");
  ExpectSameBits(a.embedding.barycentric, b.embedding.barycentric, "barycentric");
  ExpectSameBits(a.shape, b.shape, "shape");
  ExpectSameBits(a.static_offset, b.static_offset, "static_offset");
  ExpectSameBits(a.background, b.background, "background");
  ExpectSameBits(a.mesh.vertices, b.mesh.vertices, "mesh vertices");
  ExpectSameBits(a.mesh.faces, b.mesh.faces, "mesh faces");
  EXPECT_EQ(a.color_frame, b.color_frame);
  EXPECT_EQ(a.light, b.light);
  ASSERT_EQ(a.bust.has_value(), b.bust.has_value());
  if (a.bust) {
    EXPECT_EQ(a.bust->rotation, b.bust->rotation);
    EXPECT_EQ(a.bust->translation, b.bust->translation);
    ASSERT_EQ(a.bust->follow.has_value(), b.bust->follow.has_value());
    if (a.bust->follow) {
      EXPECT_EQ(a.bust->follow->head_mean, b.bust->follow->head_mean);
      EXPECT_EQ(a.bust->follow->matrix, b.bust->follow->matrix);
      EXPECT_EQ(a.bust->follow->mean, b.bust->follow->mean);
      EXPECT_EQ(a.bust->follow->min, b.bust->follow->min);
      EXPECT_EQ(a.bust->follow->max, b.bust->follow->max);
    }
  }
  EXPECT_EQ(a.gaussians.corrections, b.gaussians.corrections);
  ExpectSameBits(a.correction_map.mean, b.correction_map.mean, "corrections mean");
  ExpectSameBits(a.correction_map.matrix, b.correction_map.matrix, "corrections matrix");
  ExpectSameBits(a.correction_map.min, b.correction_map.min, "corrections least");
  ExpectSameBits(a.correction_map.max, b.correction_map.max, "corrections most");
  EXPECT_EQ(a.flame_name, b.flame_name);
  EXPECT_EQ(a.flame_sha256, b.flame_sha256);
}

std::string Slurp(const std::string& path) {
  const auto bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

void Spill(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string ErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

const std::string kBindingPointer =
    "/meshes/0/primitives/0/extensions/KHR_gaussian_splatting/extensions/COSPLAT_mesh_binding";

class AvatarFile : public testing::Test {
 protected:
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_ / "avatar.glb";
  FlameModel flame_ = BallFlame();

  GlbDocument Document() { return ReadGlb(path_, {}); }
  // Reads changed bytes without a file.
  AvatarModel Parse(const std::string& bytes) {
    const GlbDocument document = ParseGlb(path_, {bytes.begin(), bytes.end()}, {});
    return ReadBinding(document, FindBinding(FindSplats(document)));
  }
  std::string SmallAvatarBytes() {
    flame_.redistributable = true;
    WriteAvatarGlb(path_, BallAvatar(flame_, 3, 1, Basis::kDcsh), &flame_);
    return Slurp(path_);
  }
};

TEST_F(AvatarFile, EveryArrayComesBackBitForBit) {
  for (bool redistributable : {true, false})
    for (Basis basis : test::kHarmonicBases)
      for (int degree = 0; degree <= kMaxTrainedDegree; ++degree) {
        flame_.redistributable = redistributable;
        AvatarModel model = BallAvatar(flame_, 40, degree, basis);
        model.color_frame = degree % 2 ? ColorFrame::kWorld : ColorFrame::kSurface;
        if (degree == 2) model.static_offset.clear();
        if (degree == 3) model.shape.clear();
        if (degree > 1) {
          model.mesh = {};
          AttachMesh(model, flame_);
        }
        WriteAvatarGlb(path_, model, &flame_, {.truncate_degree = true});
        AvatarModel read = ReadAvatarGlb(path_);
        EXPECT_EQ(read.mesh.faces.empty(), !redistributable);
        AttachMesh(read, flame_);
        ExpectSameAvatar(model, read);
      }
}

// A bust hangs on the rim of an open mesh, and its vertices follow FLAME's.
TEST_F(AvatarFile, ABustComesBackToo) {
  const CanonicalMesh sheet = test::SheetMesh(4, 0.2f);
  flame_ = test::RandomModel(int(sheet.vertices.size() / 3), 3, 4, 1);
  flame_.sha256 = kHash;
  flame_.template_vertices = sheet.vertices;
  flame_.faces = sheet.faces;
  for (bool redistributable : {true, false}) {
    flame_.redistributable = redistributable;
    AvatarModel model = BallAvatar(flame_, 40, 1, Basis::kDcsh);
    model.bust = Bust{{0.6f, 0, 0.8f, 0, 1, 0, -0.8f, 0, 0.6f}, {0.1f, -0.2f, 0.3f}};
    model.mesh = {};
    AttachMesh(model, flame_);
    ASSERT_GT(model.mesh.faces.size(), flame_.faces.size());
    model.embedding.triangle[5] = int32_t(model.mesh.faces.size()) - 1;
    WriteAvatarGlb(path_, model, &flame_);
    EXPECT_TRUE(SummarizeGlb(path_).avatar->model.bust);
    EXPECT_EQ(SummarizeGlb(path_).avatar->version, 1);
    BustFollow& follow = model.bust->follow.emplace();
    follow.head_mean = {0.1f, 0.2f, 0.3f, 4, 5, 6, 7, 8, 9};
    for (size_t i = 0; i < follow.matrix.size(); ++i) follow.matrix[i] = 0.01f * float(i);
    follow.mean.fill(0.05f);
    follow.max.fill(0.2f);
    WriteAvatarGlb(path_, model, &flame_);
    EXPECT_EQ(SummarizeGlb(path_).avatar->version, 3);
    EXPECT_TRUE(SummarizeGlb(path_).avatar->model.bust->follow);
    AvatarModel read = ReadAvatarGlb(path_);
    EXPECT_EQ(read.mesh.faces.empty(), !redistributable);
    AttachMesh(read, flame_);
    ExpectSameAvatar(model, read);
  }
}

TEST_F(AvatarFile, OtherProgramsShowTheRestPose) {
  Camera camera;
  camera.width = camera.height = 96;
  camera.fx = camera.fy = 300;
  camera.cx = camera.cy = 48;
  camera.translation = {0.01f, -0.02f, 0.6f};
  for (Basis basis : test::kHarmonicBases)
    for (int degree = 0; degree <= 3; ++degree) {
      const AvatarModel model = BallAvatar(flame_, 300, degree, basis);
      WriteAvatarGlb(path_, model, &flame_);
      const GlbDocument document = Document();
      const Gaussians standard = test::DecodeSplats(document, FindSplats(document));
      // The avatar as it is played: bound to its mesh, colours seen through the surface frame.
      PosedGaussians posed;
      Bind(model, Surface(model.mesh), posed);
      WorldGaussians view = ViewOf(model.gaussians);
      view.position = posed.position.data();
      view.rotation = posed.rotation.data();
      view.scale_log = posed.scale_log.data();
      view.color_frame = posed.frame.data();
      const auto played = test::Image(view, basis, degree, camera);
      const auto shown = test::Image(standard, camera);
      // Measured: 4.2e-7.
      EXPECT_LT(test::LargestDifference(played, shown), 1e-5) << degree;
      EXPECT_LT(*std::min_element(played.transmittance.begin(), played.transmittance.end()), 0.5);
      // And its coefficients are the trained ones in 3DGS's SH.
      Gaussians sh = model.gaussians;
      ConvertBasis(sh, Basis::kSh);
      for (size_t i = 0; i < sh.values[kColorRest].size(); ++i)
        EXPECT_NEAR(standard.values[kColorRest][i], sh.values[kColorRest][i], 1e-4);
    }
}

TEST_F(AvatarFile, TheLiteralBasisIsNotWritten) {
  const AvatarModel model = BallAvatar(flame_, 20, 1, Basis::kDcshLiteral);
  EXPECT_TRUE(Contains(ErrorOf([&] { WriteAvatarGlb(path_, model, &flame_); }), "dcsh-literal"));
  EXPECT_FALSE(std::filesystem::exists(path_));
  const AvatarModel constant = BallAvatar(flame_, 20, 0, Basis::kDcshLiteral);
  WriteAvatarGlb(path_, constant, &flame_);
  AvatarModel read = ReadAvatarGlb(path_);
  AttachMesh(read, flame_);
  ExpectSameAvatar(constant, read);
}

AvatarModel Version2Avatar(const FlameModel& flame) {
  AvatarModel model = BallAvatar(flame, 10, 1, Basis::kSh);
  model.embedding.released = ReleasedRule{0.2497f};
  FlameParams& frame = model.canonical_frame.emplace();
  frame.expression = {0.3f, -0.1f};
  frame.pose[0] = {0.1f, 0.2f, 0.3f};
  frame.pose[2] = {0.2f, 0, 0};
  frame.translation = {0.01f, -0.02f, 0.5f};
  model.mesh = {};
  AttachMesh(model, flame);
  return model;
}

TEST_F(AvatarFile, ARuleAndACanonicalFrameComeBackInVersion2) {
  const AvatarModel model = Version2Avatar(flame_);
  EXPECT_NE(model.mesh.vertices, BallAvatar(flame_, 10, 1, Basis::kSh).mesh.vertices);
  WriteAvatarGlb(path_, model, &flame_);
  AvatarModel read = ReadAvatarGlb(path_);
  AttachMesh(read, flame_);
  ExpectSameAvatar(model, read);
  ASSERT_TRUE(read.embedding.released && read.canonical_frame);
  EXPECT_EQ(read.embedding.released->unit, model.embedding.released->unit);
  EXPECT_EQ(read.canonical_frame->expression, model.canonical_frame->expression);
  EXPECT_EQ(read.canonical_frame->pose, model.canonical_frame->pose);
  EXPECT_EQ(read.canonical_frame->translation, model.canonical_frame->translation);
  const GlbSummary summary = SummarizeGlb(path_);
  EXPECT_EQ(summary.avatar.value().version, 2);
  EXPECT_TRUE(Contains(ToString(summary), "released code"));
  // Expression directions are those of the mesh at rest only.
  WriteAvatarGlb(path_, model, &flame_, {.embed_flame = true});
  EXPECT_EQ(SummarizeGlb(path_).avatar.value().expression_count, 0u);
  // Without either the file is one that version 1's readers understand.
  WriteAvatarGlb(path_, BallAvatar(flame_, 10, 1, Basis::kSh), &flame_);
  EXPECT_EQ(SummarizeGlb(path_).avatar.value().version, 1);
}

TEST_F(AvatarFile, HostileRulesAndFramesAreErrorsThatNameTheField) {
  WriteAvatarGlb(path_, Version2Avatar(flame_), &flame_);
  const test::GlbBytes valid = test::SplitGlb(Slurp(path_));
  const std::vector<std::tuple<const char*, json, const char*>> cases{
      {"/rule/name", "paper", "rule.name: is 'paper'"},
      {"/rule/unit", 0, "rule.unit: is 0"},
      {"/rule/unit", 1e300, "rule.unit: is 1e+300"},
      {"/rule", "splatting-avatar-released", "rule"},
      {"/canonicalFrame/pose", {1, 2, 3}, "canonicalFrame.pose: found 3 numbers, expected 15"},
      {"/canonicalFrame/expression", "x", "canonicalFrame.expression"},
      {"/canonicalFrame/translation", {0, 0, 1e300}, "canonicalFrame.translation"},
  };
  for (const auto& [field, value, named] : cases) {
    test::GlbBytes changed = valid;
    changed.json[json::json_pointer(kBindingPointer + field)] = value;
    const std::string error = ErrorOf([&, glb = test::JoinGlb(changed)] { Parse(glb); });
    EXPECT_TRUE(Contains(error, named)) << error;
  }
}

TEST_F(AvatarFile, CorrectionsComeBackInStepsOf16Bits) {
  const AvatarModel model =
      test::WithCorrections(BallAvatar(flame_, 20, 1, Basis::kDcsh), flame_, 3);
  WriteAvatarGlb(path_, model, &flame_);
  AvatarModel read = ReadAvatarGlb(path_);
  AttachMesh(read, flame_);
  Buffer<float>& bases = read.gaussians.values[kCorrection];
  const Buffer<float>& exact = model.gaussians.values[kCorrection];
  ASSERT_EQ(bases.size(), exact.size());
  for (size_t i = 0; i < bases.size(); ++i) EXPECT_NEAR(bases[i], exact[i], 0.5f * 0x1p-18f);
  // What was read is written with the same bytes.
  const std::string again = folder_ / "again.glb";
  WriteAvatarGlb(again, read, &flame_);
  AvatarModel second = ReadAvatarGlb(again);
  AttachMesh(second, flame_);
  WriteAvatarGlb(path_, second, &flame_);
  EXPECT_EQ(Slurp(path_), Slurp(again));
  bases = exact;
  ExpectSameAvatar(model, read);
  const GlbSummary summary = SummarizeGlb(path_);
  EXPECT_EQ(summary.avatar.value().version, 4);
  EXPECT_EQ(summary.avatar->model.gaussians.corrections, 3);
  EXPECT_TRUE(Contains(ToString(summary), "3 corrections"));
  // Other programs see the Gaussians as they are at rest.
  const Gaussians rest = RestPose(model);
  EXPECT_EQ(rest.corrections, 0);
  EXPECT_NE(rest.values[kOpacityLogit], model.gaussians.values[kOpacityLogit]);
}

TEST_F(AvatarFile, LightComesBackInVersion4) {
  AvatarModel model = BallAvatar(flame_, 20, 1, Basis::kDcsh);
  model.light.emplace().fill(0.25f);
  WriteAvatarGlb(path_, model, &flame_);
  AvatarModel read = ReadAvatarGlb(path_);
  AttachMesh(read, flame_);
  ExpectSameAvatar(model, read);
  const GlbSummary summary = SummarizeGlb(path_);
  EXPECT_EQ(summary.avatar.value().version, 4);
  EXPECT_TRUE(Contains(ToString(summary), "a light that stands still"));
  // Other programs see it lit as at rest.
  EXPECT_NE(RestPose(model).values[kColorDc], model.gaussians.values[kColorDc]);
  const test::GlbBytes valid = test::SplitGlb(Slurp(path_));
  json huge = json::array();
  for (size_t k = 0; k < model.light->size(); ++k) huge.push_back(k == 7 ? 1e300 : 0);
  json strong = huge;
  strong[7] = 40;
  const std::vector<std::pair<json, const char*>> cases{
      {json::array({1, 2, 3}), "light: found 3 numbers, expected 24"},
      {7, "light"},
      {strong, "light[7]: is 40.0"},
      {huge, "light"}};
  for (const auto& [value, named] : cases) {
    test::GlbBytes changed = valid;
    changed.json[json::json_pointer(kBindingPointer + std::string("/light"))] = value;
    const std::string error = ErrorOf([&, glb = test::JoinGlb(changed)] { Parse(glb); });
    EXPECT_TRUE(Contains(error, named)) << error;
  }
  for (const float bad : {NAN, 40.0f}) {
    (*model.light)[2] = bad;
    EXPECT_TRUE(Contains(ErrorOf([&] { WriteAvatarGlb(path_, model, &flame_); }), "light")) << bad;
  }
}

TEST_F(AvatarFile, HostileCorrectionsAreErrorsThatNameTheField) {
  AvatarModel model = test::WithCorrections(BallAvatar(flame_, 20, 1, Basis::kDcsh), flame_, 3);
  WriteAvatarGlb(path_, model, &flame_);
  const test::GlbBytes valid = test::SplitGlb(Slurp(path_));
  const std::vector<std::tuple<const char*, json, const char*>> cases{
      {"/corrections/count", 0, "corrections.count: is 0"},
      {"/corrections/count", 1000, "corrections.count: is 1000"},
      {"/corrections/count", 2, "corrections.matrix"},
      {"/corrections/mean", json::array(), "corrections.mean"},
      {"/corrections/matrix", {1, 2, 3}, "corrections.matrix"},
      {"/corrections/most", {1, 1, -2}, "corrections.most[2]: is -2"},
      {"/corrections/bases", 0, "corrections.bases"},
      {"/corrections/bases", -1, "corrections.bases"},
      {"/corrections/step", json::array({1, 2}), "corrections.step"},
      {"/corrections/step", json::array(), "corrections.step"},
      {"/corrections/step/2", 1e37, "corrections.step[2]"},
      {"/corrections", 7, "corrections"},
  };
  for (const auto& [field, value, named] : cases) {
    test::GlbBytes changed = valid;
    changed.json[json::json_pointer(kBindingPointer + field)] = value;
    const std::string error = ErrorOf([&, glb = test::JoinGlb(changed)] { Parse(glb); });
    EXPECT_TRUE(Contains(error, named)) << field << ": " << error;
  }
}

TEST_F(AvatarFile, LicensedFlameDataStaysOut) {
  const AvatarModel model = BallAvatar(flame_, 20, 1, Basis::kDcsh);
  const auto holds = [&](const std::vector<float>& values, size_t count) {
    const std::string part(reinterpret_cast<const char*>(values.data()), 4 * count);
    return Contains(Slurp(path_), part);
  };
  for (const FlameModel* flame : {&flame_, static_cast<FlameModel*>(nullptr)}) {
    WriteAvatarGlb(path_, model, flame);
    EXPECT_EQ(Document().meshes.size(), 1u);
    EXPECT_FALSE(holds(model.mesh.vertices, 3));
    EXPECT_FALSE(holds(flame_.expression_directions, 3));
    EXPECT_TRUE(ReadAvatarGlb(path_).mesh.faces.empty());
    EXPECT_TRUE(ReadAvatarGlb(path_).mesh.vertices.empty());
    EXPECT_TRUE(holds(model.static_offset, model.static_offset.size()));
  }
  WriteAvatarGlb(path_, model, &flame_, {.embed_flame = true});
  EXPECT_TRUE(holds(model.mesh.vertices, model.mesh.vertices.size()));
  EXPECT_TRUE(holds(flame_.expression_directions, flame_.expression_directions.size()));
  WriteAvatarGlb(path_, model, nullptr, {.embed_flame = true});
  EXPECT_TRUE(Document().meshes.at(1).primitives.at(0).targets.empty());
  ExpectSameAvatar(model, ReadAvatarGlb(path_));
}

TEST_F(AvatarFile, TheMeshIsAnOrdinaryOneWithMorphTargets) {
  const json j = test::SplitGlb(SmallAvatarBytes()).json;
  EXPECT_EQ(j["extensionsUsed"], json({"KHR_gaussian_splatting", "COSPLAT_mesh_binding"}));
  EXPECT_EQ(j["scene"], 0);
  EXPECT_EQ(j["nodes"][j["scenes"][0]["nodes"][0].get<int>()]["mesh"], 0);
  EXPECT_EQ(j["nodes"][j["scenes"][1]["nodes"][0].get<int>()]["mesh"], 1);
  const json& mesh = j["meshes"][1];
  EXPECT_EQ(mesh["extras"]["targetNames"].size(), 4u);
  EXPECT_EQ(mesh["primitives"][0]["targets"].size(), 4u);
  EXPECT_EQ(mesh["primitives"][0]["mode"], 4);
  EXPECT_EQ(j["accessors"][mesh["primitives"][0]["indices"].get<int>()]["count"],
            3 * flame_.faces.size());
}

TEST_F(AvatarFile, AttachMeshChecksTheModel) {
  const AvatarModel model = BallAvatar(flame_, 20, 0, Basis::kDcsh);
  WriteAvatarGlb(path_, model, &flame_);
  FlameModel other = flame_;
  other.sha256 = std::string(64, 'b');
  AvatarModel read = ReadAvatarGlb(path_);
  const std::string error = ErrorOf([&] { AttachMesh(read, other); });
  EXPECT_TRUE(Contains(error, kHash) && Contains(error, other.sha256)) << error;
  EXPECT_TRUE(read.mesh.faces.empty());
  AttachMesh(read, other, true);
  ExpectSameBits(read.mesh.vertices, model.mesh.vertices, "mesh");
  EXPECT_NE(ErrorOf([&] { WriteAvatarGlb(path_, model, &other); }), "");

  AvatarModel unfit = ReadAvatarGlb(path_);
  unfit.static_offset.clear();
  FlameModel smaller = test::RandomModel(6);
  EXPECT_TRUE(Contains(ErrorOf([&] { AttachMesh(unfit, smaller, true); }), "faces"));
  EXPECT_TRUE(unfit.mesh.faces.empty());
}

TEST_F(AvatarFile, DegreeFourOnlyWhenToldToTruncate) {
  const AvatarModel model = BallAvatar(flame_, 20, 4, Basis::kDcsh);
  EXPECT_TRUE(Contains(ErrorOf([&] { WriteAvatarGlb(path_, model, &flame_); }), "degree"));
  EXPECT_FALSE(std::filesystem::exists(path_));
  WriteAvatarGlb(path_, model, &flame_, {.truncate_degree = true});
  const GlbSummary summary = SummarizeGlb(path_);
  EXPECT_EQ(summary.degree, 3);
  EXPECT_EQ(summary.avatar.value().model.gaussians.degree, 4);
}

TEST_F(AvatarFile, Summary) {
  AvatarModel model = BallAvatar(flame_, 20, 2, Basis::kDcsh);
  WriteAvatarGlb(path_, model, &flame_, {.embed_flame = true});
  const GlbSummary summary = SummarizeGlb(path_);
  EXPECT_EQ(summary.gaussians, 20u);
  EXPECT_EQ(summary.degree, 2);
  ASSERT_TRUE(summary.avatar);
  EXPECT_EQ(summary.avatar->vertex_count, size_t(flame_.vertex_count));
  EXPECT_EQ(summary.avatar->face_count, flame_.faces.size());
  EXPECT_EQ(summary.avatar->expression_count, 4u);
  EXPECT_EQ(summary.avatar->model.shape.size(), 2u);
  EXPECT_FALSE(summary.avatar->model.mesh.faces.empty() ||
               summary.avatar->model.static_offset.empty());
  const std::string text = ToString(summary);
  for (const char* part :
       {"20 Gaussians", "dcsh", "surface", "ball.npz", "4 morph targets", "COSPLAT_mesh_binding"})
    EXPECT_TRUE(Contains(text, part)) << text;
}

TEST_F(AvatarFile, BadAvatarsAreNotWritten) {
  const AvatarModel good =
      test::WithCorrections(BallAvatar(flame_, 20, 1, Basis::kDcsh), flame_, 2);
  WriteAvatarGlb(path_, good, &flame_);
  const std::string before = Slurp(path_);
  const auto refused = [&](const std::function<void(AvatarModel&)>& spoil) {
    AvatarModel bad = good;
    spoil(bad);
    return ErrorOf([&] { WriteAvatarGlb(path_, bad, nullptr); });
  };
  for (int a = 0; a < kAttributeCount; ++a) {
    EXPECT_NE(refused([&](AvatarModel& m) { m.gaussians.values[a][1] = NAN; }), "") << a;
    EXPECT_NE(refused([&](AvatarModel& m) { m.gaussians.values[a].pop_back(); }), "") << a;
  }
  EXPECT_TRUE(Contains(refused([](AvatarModel& m) { m.mesh = {}; }), "mesh"));
  EXPECT_TRUE(Contains(refused([](AvatarModel& m) { m.correction_map.max.pop_back(); }), "most"));
  const auto bad_follow = [](AvatarModel& m) { m.bust.emplace().follow.emplace().matrix[3] = NAN; };
  EXPECT_TRUE(Contains(refused(bad_follow), "bust follow matrix"));
  EXPECT_TRUE(
      Contains(refused([](AvatarModel& m) { m.embedding.triangle[7] = 100000; }), "triangle[7]"));
  EXPECT_TRUE(
      Contains(refused([](AvatarModel& m) { m.embedding.triangle[7] = -1; }), "triangle[7]"));
  EXPECT_TRUE(
      Contains(refused([](AvatarModel& m) { m.embedding.triangle.pop_back(); }), "triangle"));
  EXPECT_TRUE(
      Contains(refused([](AvatarModel& m) { m.embedding.barycentric[2][1] = INFINITY; }), "bary"));
  EXPECT_TRUE(Contains(refused([](AvatarModel& m) { m.static_offset.pop_back(); }), "static_"));
  EXPECT_TRUE(Contains(refused([](AvatarModel& m) { m.shape[0] = NAN; }), "shape"));
  EXPECT_TRUE(Contains(refused([](AvatarModel& m) { m.background[0] = NAN; }), "background"));
  EXPECT_TRUE(
      Contains(refused([](AvatarModel& m) { m.embedding.released = ReleasedRule{0}; }), "rule"));
  const auto bad_frame = [](AvatarModel& m) { m.canonical_frame.emplace().pose[1][2] = NAN; };
  EXPECT_TRUE(Contains(refused(bad_frame), "canonical pose"));
  EXPECT_EQ(Slurp(path_), before);  // nothing was half written
}

TEST_F(AvatarFile, ANameOfAnyBytesIsWritten) {
  AvatarModel model = BallAvatar(flame_, 3, 0, Basis::kDcsh);
  model.flame_name = "fl\xffme \"2023\"\n.pkl";
  WriteAvatarGlb(path_, model, nullptr);
  EXPECT_TRUE(Contains(ReadAvatarGlb(path_).flame_name, " \"2023\"\n.pkl"));
}

TEST_F(AvatarFile, SplatsWithoutABindingAreNoAvatar) {
  test::GlbBytes glb = test::SplitGlb(SmallAvatarBytes());
  json& extension = glb.json["meshes"][0]["primitives"][0]["extensions"];
  extension["KHR_gaussian_splatting"].erase("extensions");
  Spill(path_, test::JoinGlb(glb));
  EXPECT_TRUE(Contains(ErrorOf([&] { ReadAvatarGlb(path_); }), "COSPLAT_mesh_binding"));
  EXPECT_FALSE(SummarizeGlb(path_).avatar);
  extension = json::object();
  Spill(path_, test::JoinGlb(glb));
  EXPECT_TRUE(Contains(ErrorOf([&] { SummarizeGlb(path_); }), "KHR_gaussian_splatting"));
}

TEST_F(AvatarFile, HostileBindingsAreErrorsThatNameTheField) {
  const test::GlbBytes valid = test::SplitGlb(SmallAvatarBytes());
  const json& binding = valid.json[json::json_pointer(kBindingPointer)];
  struct Case {
    const char* field;
    json value;
    const char* named;
  };
  const std::vector<Case> cases{
      {"/version", 5, "version: is 5"},
      {"/version", 0, "version: is 0"},
      {"/version", 4294967297ll, "version"},
      {"/version", "1", "version"},
      {"/degree", 5, "degree: is 5"},
      {"/degree", -1, "degree: is -1"},
      {"/degree", 2, "colorRest: has 3 accessors, expected 8"},
      {"/basis", "fourier", "basis"},
      {"/colorFrame", "moon", "colorFrame"},
      {"/triangle", 999, "triangle: refers to accessor 999"},
      {"/triangle", -1, "triangle: refers to accessor -1"},
      {"/triangle", binding["offset"], "triangle: accessor"},
      {"/barycentric", binding["offset"], "barycentric: accessor"},
      {"/rotation", nullptr, "rotation"},
      {"/opacityLogit", binding["shape"], "opacityLogit: accessor has 2 elements, expected 3"},
      {"/colorRest/1", "x", "colorRest[1]"},
      {"/staticOffset", binding["offset"], "staticOffset: accessor has 3 elements"},
      {"/background", {1, 1}, "background"},
      {"/flame", "flame.pkl", "flame"},
      {"/flame/sha256", 5, "flame.sha256"},
      {"/canonicalMesh/faceCount", 0, "faceCount"},
      {"/canonicalMesh/faceCount", 1, "canonicalMesh.mesh"},
      {"/canonicalMesh/vertexCount", 7, "canonicalMesh.mesh"},
      {"/canonicalMesh/mesh", 0, "canonicalMesh.mesh"},
      {"/canonicalMesh/mesh", 2, "canonicalMesh.mesh: refers to mesh 2, but the file has 2 meshes"},
      {"", 5, "COSPLAT_mesh_binding"},
  };
  for (const Case& c : cases) {
    test::GlbBytes glb = valid;
    glb.json[json::json_pointer(kBindingPointer + c.field)] = c.value;
    const std::string error = ErrorOf([&] { Parse(test::JoinGlb(glb)); });
    EXPECT_TRUE(Contains(error, c.named)) << c.field << " said: " << error;
  }
}

TEST_F(AvatarFile, IndicesOutOfRangeAreErrors) {
  const test::GlbBytes valid = test::SplitGlb(SmallAvatarBytes());
  const auto overwritten = [&](int accessor) {
    test::GlbBytes glb = valid;
    const int view = glb.json["accessors"][accessor]["bufferView"];
    const size_t offset = glb.json["bufferViews"][view].value("byteOffset", 0);
    glb.binary.replace(offset + 4, 4, test::Bytes32(0x80000001));
    return ErrorOf([&] { Parse(test::JoinGlb(glb)); });
  };
  const json& binding = valid.json[json::json_pointer(kBindingPointer)];
  EXPECT_TRUE(Contains(overwritten(binding["triangle"]), "triangle: Gaussian 1 is on face"));
  const int indices = valid.json["meshes"][1]["primitives"][0]["indices"];
  EXPECT_TRUE(Contains(overwritten(indices), "face 0 refers to vertex 2147483649"));
}

TEST_F(AvatarFile, DamageNeverCrashes) {
  const std::string bytes = SmallAvatarBytes();
  for (size_t size = 0; size < bytes.size(); size += 1 + size / 500)
    ASSERT_NE(ErrorOf([&] { Parse(bytes.substr(0, size)); }), "") << "cut at " << size;
  Rng rng{9};
  const size_t json_end = 20 + test::Number32(bytes, 12);
  for (int round = 0; round < 1500; ++round) {
    std::string damaged = bytes;
    for (uint64_t i = 0; i < 1 + rng.Below(4); ++i)
      damaged[rng.Below(json_end)] = char(rng.Below(256));
    ErrorOf([&] { Parse(damaged); });  // an Error or an avatar: anything else ends the test
  }
}

// Every number is a short binary fraction, so that all arithmetic is exact on any machine.
AvatarModel GoldenAvatar(FlameModel& flame) {
  flame.name = "golden";
  flame.redistributable = true;
  flame.vertex_count = 4;
  flame.expression_count = 1;
  flame.faces = {{0, 1, 2}, {2, 1, 3}};
  flame.expression_directions.assign(12, 0);
  flame.expression_directions[5] = 0.25f;
  AvatarModel model;
  model.flame_name = flame.name;
  model.mesh.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  model.mesh.faces = flame.faces;
  model.embedding.triangle = {0, 1};
  model.embedding.barycentric = {{{0.25f, 0.5f}, {0.125f, 0.125f}}};
  model.shape = {0.5f, -2};
  model.static_offset.assign(12, 0.0078125f);
  model.background = {1, 0.5f, 0};
  Gaussians& g = model.gaussians;
  g.degree = 1;
  g.basis = Basis::kDcsh;
  g.Resize(2);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t k = 0; k < g.values[a].size(); ++k) g.values[a][k] = 0.0625f * float(k + 1);
  for (size_t i = 0; i < 2; ++i) {
    const float rotation[2][4] = {{1, 0, 0, 0}, {0, 0, 2, 0}};
    std::copy_n(rotation[i], 4, g.at(kRotation, i));
  }
  return model;
}

// With a rule of its own and a canonical mesh that is posed.
AvatarModel GoldenAvatar2(FlameModel& flame) {
  AvatarModel model = GoldenAvatar(flame);
  model.embedding.released = ReleasedRule{0.25f};
  FlameParams& frame = model.canonical_frame.emplace();
  frame.expression = {0.5f};
  frame.pose[2] = {0.25f, 0, 0};
  frame.translation = {0, 0.125f, 0};
  return model;
}

void AddGoldenCorrections(AvatarModel& model) {
  Gaussians& g = model.gaussians;
  g.corrections = 1;
  g.values[kCorrection].assign(model.size() * size_t(g.width(kCorrection)), 0.0625f);
  CorrectionMap& map = model.correction_map;
  map.mean.assign(1 + kMinCorrectionInputs, 0.125f);
  map.matrix.assign(map.mean.size(), 0.25f);
  map.min = {-1};
  map.max = {1};
}

// With corrections, the range of training and a map from blendshape scores.
AvatarModel GoldenAvatar3(FlameModel& flame) {
  AvatarModel model = GoldenAvatar(flame);
  AddGoldenCorrections(model);
  model.trained_range.emplace(TrainedRange{{-2}, {2}, {0, 0.5f, 0.25f, 0.5f, 0.5f}});
  BlendshapeMap& scores = model.blendshapes.emplace();
  scores.names = {"jawOpen"};
  scores.min = {0};
  scores.max = {0.5f};
  scores.offset.assign(1 + kMappedTurns, 0.125f);
  scores.matrix.assign(1 + kMappedTurns, 0.0625f);
  return model;
}

AvatarModel GoldenAvatar4(FlameModel& flame) {
  AvatarModel model = GoldenAvatar(flame);
  Light& light = model.light.emplace();
  for (size_t k = 0; k < light.size(); ++k) light[k] = 0.0625f * float(k);
  AddGoldenCorrections(model);
  return model;
}

// tests/golden/avatar_vN.glb pin the versions of the format. When it changes on purpose, keep them
// (old files must still be read), add the next beside them, and write that one by running
//   COSPLAT_WRITE_GOLDEN=1 cosplat_test_avatar_io --gtest_filter=*Golden*
TEST_F(AvatarFile, GoldenFilesOfEveryVersion) {
  const auto make = {GoldenAvatar, GoldenAvatar2, GoldenAvatar3, GoldenAvatar4};
  int version = 0;
  for (const auto& golden_avatar : make) {
    const std::string golden = std::string(COSPLAT_SOURCE_DIR) + "/tests/golden/avatar_v" +
                               std::to_string(++version) + ".glb";
    FlameModel flame;
    const AvatarModel model = golden_avatar(flame);
    if (std::getenv("COSPLAT_WRITE_GOLDEN") && version == kBindingVersion)
      WriteAvatarGlb(golden, model, &flame);
    const AvatarModel read = ReadAvatarGlb(golden);
    ExpectSameAvatar(model, read);
    EXPECT_EQ(SummarizeGlb(golden).avatar->version, version);
    EXPECT_EQ(read.embedding.released.has_value(), version == 2);
    EXPECT_EQ(read.canonical_frame.has_value(), version == 2);
    ASSERT_EQ(read.trained_range.has_value(), version == 3);
    if (version == 3) {
      EXPECT_EQ(read.trained_range->expression_most, model.trained_range->expression_most);
      EXPECT_EQ(read.blendshapes.value().matrix, model.blendshapes->matrix);
    }
    WriteAvatarGlb(path_, model, &flame);
    // The rest pose of the others is not exact on every machine.
    if (version == 1) EXPECT_EQ(Slurp(path_), Slurp(golden));
  }
  ASSERT_EQ(version, kBindingVersion);
}

}  // namespace
}  // namespace cosplat
