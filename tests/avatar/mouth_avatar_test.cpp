// An avatar whose FLAME model had teeth and a mouth added (flame/mouth.h): training, file,
// playback.
#include <gtest/gtest.h>

#include "avatar/io/avatar_file.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/play/player.h"
#include "flame/eyelids.h"
#include "flame/mouth.h"
#include "splat/base/files.h"
#include "tests/avatar/training_fixture.h"
#include "tests/flame/hollow_head.h"
#include "tests/support/expect_error.h"
#include "tests/support/glb_bytes.h"

namespace cosplat::test {
namespace {

TEST(AvatarWithAMouth, AndLidsIsTrainedWrittenAndPlayed) {
  const FlameModel hollow = HollowHead(), filled = WithEyelids(WithMouth(HollowHead()));
  TrackedVideo video = LoadSmallVideo(4, 1);
  video.train[0].params.eyelids = {0.3f, 0.6f};
  EyelidsToExpression(filled, video);
  const TrackedFrame shown = video.train[0];
  AvatarSettings settings;
  settings.initial_gaussians = 3000;
  Training<> run(std::move(video), settings, {}, filled);
  run.Run(20);
  const AvatarModel model = run.Model();
  EXPECT_TRUE(model.has_mouth && model.has_eyelids);
  EXPECT_EQ(model.trained_range->expression_most.back(), 0.6f);
  size_t in_mouth = 0;
  for (const int32_t t : model.embedding.triangle) in_mouth += size_t(t) >= hollow.faces.size();
  EXPECT_GT(in_mouth, 10u);

  const TemporaryFolder folder;
  const std::string path = folder / "avatar.glb";
  WriteAvatarGlb(path, model, &filled);
  const GlbSummary summary = SummarizeGlb(path);
  EXPECT_EQ(summary.avatar.value().version, 4);
  EXPECT_NE(ToString(summary).find("teeth and a mouth added, eyelids added"), std::string::npos);
  AvatarModel read = ReadAvatarGlb(path);
  EXPECT_TRUE(read.has_mouth && read.has_eyelids);
  const FlameModel flame = FlameOf(read, hollow);
  EXPECT_EQ(flame.vertex_count, filled.vertex_count);
  AttachMesh(read, flame);
  EXPECT_EQ(read.mesh.vertices, model.mesh.vertices);
  RenderedImage played, trained;
  Player(read, flame).RenderOver(shown.params, shown.camera, {1, 1, 1}, played);
  Player(model, filled).RenderOver(shown.params, shown.camera, {1, 1, 1}, trained);
  EXPECT_EQ(played.color, trained.color);

  // The model as its file has it, and one with a mouth for an avatar that has none.
  AvatarModel unattached = ReadAvatarGlb(path);
  unattached.mesh = {};
  unattached.embedding.triangle = {0};
  ExpectError([&] { AttachMesh(unattached, hollow); },
              {"flame", "the avatar, but not the model, has a mouth"});
  AvatarModel without = unattached;
  without.has_mouth = false;
  without.mesh = {};
  ExpectError([&] { AttachMesh(without, filled); },
              {"flame", "the model, but not the avatar, has a mouth"});
}

TEST(AvatarWithAMouth, OfAnotherGeometryIsRefused) {
  TrackedVideo video = LoadSmallVideo(2, 2);
  AvatarSettings settings;
  settings.initial_gaussians = 500;
  const FlameModel filled = WithMouth(HollowHead());
  const Training<> run(std::move(video), settings, {}, filled);
  const TemporaryFolder folder;
  const std::string path = folder / "avatar.glb";
  WriteAvatarGlb(path, run.Model(), &filled);
  const std::vector<char> bytes = ReadFile(path);
  GlbBytes glb = SplitGlb({bytes.begin(), bytes.end()});
  auto& flame = glb.json["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]
                        ["extensions"]["COSPLAT_mesh_binding"]["flame"];
  flame["mouth"] = 3;
  WriteFileAtomically(path, JoinGlb(glb));
  ExpectError([&] { ReadAvatarGlb(path); }, {path, "flame.mouth", "3"});
  flame["mouth"] = 1;
  flame["eyelids"] = 0;
  WriteFileAtomically(path, JoinGlb(glb));
  ExpectError([&] { ReadAvatarGlb(path); }, {path, "flame.eyelids", "0"});
}

}  // namespace
}  // namespace cosplat::test
