// docs/study/bricks.py in Blender: a small scene of it is one that LoadScene reads and CheckScene
// finds nothing wrong with.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "splat/io/dataset.h"
#include "splat/io/scene_check.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

TEST(Bricks, AreASceneOfRenderings) {
  if (std::system("blender --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "needs Blender";
  const TemporaryFolder folder;
  const std::string said = folder / "said.txt", to = folder / "bricks";
  const std::string command =
      "blender -b --factory-startup -noaudio --python-exit-code 1 --python " COSPLAT_BRICKS " -- " +
      to + " 40 8 2 >" + said + " 2>&1 || { cat " + said + "; false; }";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const SceneData scene = LoadScene(to, {.eval = true});
  EXPECT_TRUE(scene.renderings);
  ASSERT_EQ(scene.train.size(), 8u);
  ASSERT_EQ(scene.test.size(), 2u);
  for (const SceneView& view : scene.train) {
    const Image8 image = LoadViewImage(view);
    ASSERT_EQ(image.width, 40);
    size_t solid = 0;
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) solid += image.at(x, y, 3) == 255;
    EXPECT_GT(solid, 200u) << view.name;
    EXPECT_LT(solid, 1200u) << view.name;
    for (int x = 0; x < 40; ++x) EXPECT_EQ(image.at(x, 0, 3), 0) << view.name;
  }
  for (const Finding& finding : CheckScene(scene)) EXPECT_FALSE(finding.wrong) << finding.text;
}

}  // namespace
}  // namespace cosplat::test
