#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "avatar/io/avatar_file.h"
#include "splat/io/splat_file.h"
#include "splat/io/vq.h"
#include "tests/avatar/meshes.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

AvatarModel BallAvatar(size_t n) {
  AvatarModel model = test::RandomAvatar(test::SphereMesh(2), n, 3);
  const auto position = model.gaussians.values[kPosition];
  model.gaussians = test::RandomGaussians(n, 2, Basis::kSh, 4);
  model.gaussians.values[kPosition] = position;
  return model;
}

QuantisedSplats Quantised(const AvatarModel& model) {
  QuantisedSplats splats = Quantise(model.gaussians, SizeSignificance(model.gaussians), {32, 1, 0});
  AddEmbedding(model.embedding, splats);
  return splats;
}

TEST(QuantisedAvatar, ComesBackOnItsTriangles) {
  const TemporaryFolder folder;
  const AvatarModel model = BallAvatar(200);
  WriteVqFile(folder / "a.zip", Quantised(model));
  AvatarModel read = model;
  read.embedding.triangle.clear();
  read.embedding.barycentric.clear();
  read.gaussians = {};
  ReadQuantisedAvatar(folder / "a.zip", read);
  EXPECT_EQ(read.embedding.triangle, model.embedding.triangle);
  EXPECT_EQ(read.embedding.barycentric, model.embedding.barycentric);
  EXPECT_EQ(read.gaussians.basis, Basis::kSh);
  EXPECT_EQ(read.gaussians.values[kPosition], model.gaussians.values[kPosition]);
  for (const Attribute a : {kScaleLog, kOpacityLogit, kColorDc, kColorRest})
    for (size_t i = 0; i < model.gaussians.values[a].size(); ++i)
      EXPECT_NEAR(read.gaussians.values[a][i], model.gaussians.values[a][i], 2e-3);
  ExpectError([&] { ReadSplats(folder / "a.zip"); }, {"a.zip", "kind", "avatar"});
}

TEST(QuantisedAvatar, BadFilesAreErrors) {
  const TemporaryFolder folder;
  const AvatarModel model = BallAvatar(20);
  const auto expect = [&](const std::function<void(QuantisedSplats&)>& change,
                          const std::vector<std::string>& parts) {
    QuantisedSplats splats = Quantised(model);
    change(splats);
    WriteVqFile(folder / "a.zip", splats);
    AvatarModel read = model;
    ExpectError([&] { ReadQuantisedAvatar(folder / "a.zip", read); }, parts);
    EXPECT_EQ(read.gaussians.values, model.gaussians.values) << "left half changed";
  };
  expect([](QuantisedSplats& s) { s.kind = "scene"; }, {"a.zip", "kind", "'scene'", "'avatar'"});
  expect([](QuantisedSplats& s) { s.more = {}; }, {"a.zip", "triangle", "missing"});
  std::vector<int32_t> triangles(20, 0);
  triangles[7] = int32_t(model.mesh.faces.size());
  expect([&](QuantisedSplats& s) { s.more.Add("triangle", {20}, triangles); },
         {"a.zip", "triangle", "number 7"});
  expect(
      [&](QuantisedSplats& s) {
        s.more.Add("triangle", {1, 20}, triangles);
      },
      {"a.zip", "triangle", "[1, 20]", "[20]"});
  std::vector<float> barycentric(40, 0.3f);
  barycentric[5] = NAN;
  expect(
      [&](QuantisedSplats& s) {
        s.more.Add("barycentric", {20, 2}, barycentric);
      },
      {"a.zip", "barycentric", "number 5", "not finite"});
}

}  // namespace
}  // namespace cosplat
