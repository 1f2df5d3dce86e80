// CheckScene on a scene that is right, and on the same with one thing broken.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "splat/io/scene_check.h"
#include "tests/street/findings.h"
#include "tests/street/nerf_scene.h"

namespace cosplat::test {
namespace {

// Views of the plane over a wide path, with points.
struct Scene : NerfScene {
  explicit Scene(int views = 24) : NerfScene(views) { WritePoints("points3D.ply"); }
};

void ChangeImages(const NerfScene& scene, const std::function<void(int, Image8&)>& change) {
  for (int i = 0; i < int(scene.json["frames"].size()); ++i) {
    Image8 image = ReadImage(scene.folder / scene.Frame(i));
    change(i, image);
    WriteImage(scene.folder / scene.Frame(i), image);
  }
}

TEST(CheckScene, SaysNothingOfGoodData) {
  const Scene scene;
  EXPECT_EQ(Said(CheckScene(scene.Load())), "");
  EXPECT_EQ(Said(CheckScene(scene.Load({1, true, false}))), "");
}

// Of three, views from elsewhere have some 12 dB.
TEST(CheckScene, FewViewsAreWorthALine) {
  const auto of = [](int views) { return CheckScene(Scene(views).Load()); };
  const std::vector<Finding> one = of(1), five = of(5);
  ASSERT_EQ(one.size(), 1u) << Said(one);
  EXPECT_FALSE(one.front().wrong);
  EXPECT_NE(one.front().text.find("1 training view:"), std::string::npos) << Said(one);
  EXPECT_NE(Said(five).find("5 training views:"), std::string::npos) << Said(five);
  EXPECT_EQ(Said(of(6)), "");
}

TEST(CheckScene, PointsThatAProgramStrewedSayNothing) {
  const Scene scene;
  SceneData data = scene.Load();
  for (const bool alike : {false, true}) {
    uint32_t state = 1;
    for (uint8_t& value : data.point_colors) {
      state = state * 1664525u + 1013904223u;
      value = alike ? 128 : uint8_t(state >> 24);
    }
    EXPECT_EQ(Said(CheckScene(data)), "");
  }
}

TEST(CheckScene, FindsExchangedImages) {
  Scene scene;
  const Json frames = scene.json["frames"];
  for (size_t i = 0; i < frames.size(); ++i)
    scene.json["frames"][i]["file_path"] = frames[(7 * i + 5) % frames.size()]["file_path"];
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(AnyWrong(findings)) << Said(findings);
}

// Most of a building's points are behind walls wherever one stands: their colours are not what the
// images show there.
TEST(CheckScene, PointsBehindWallsSayNothing) {
  Scene scene;
  const auto with_more_behind = [&] {
    SceneData data = scene.Load();
    for (int room = 0; room < 4; ++room)
      for (int i = 0; i < 400; ++i) {
        const double x = 0.2 * (i % 20 - 9.5), y = 0.16 * (i / 20 - 9.5), z = 5 + room;
        for (const double p : {x, y, z}) data.points.push_back(float(p));
        for (const uint8_t c : PlaneColor(y + 0.3 * room, -x)) data.point_colors.push_back(c);
      }
    return data;
  };
  EXPECT_EQ(Said(CheckScene(with_more_behind())), "");
  const Json frames = scene.json["frames"];
  for (size_t i = 0; i < frames.size(); ++i)
    scene.json["frames"][i]["file_path"] = frames[(7 * i + 5) % frames.size()]["file_path"];
  EXPECT_TRUE(AnyWrong(CheckScene(with_more_behind())));
}

TEST(CheckScene, FindsMirroredImages) {
  const Scene scene;
  ChangeImages(scene, [](int, Image8& image) {
    const Image8 old = image;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = old.at(image.width - 1 - x, y, c);
  });
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "mirrored left to right")) << Said(findings);
}

TEST(CheckScene, FindsTheWrongFocalLength) {
  Scene scene;
  scene.json["fl_x"] = scene.json["fl_y"] = 2 * NerfScene::kFocal;
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "focal length of half")) << Said(findings);
}

TEST(CheckScene, FindsTheOtherConventionOfAxes) {
  Scene scene;
  for (Json& frame : scene.json["frames"])
    for (int row = 0; row < 3; ++row)
      for (int column : {1, 2}) {
        const double value = frame["transform_matrix"][row][column];
        frame["transform_matrix"][row][column] = -value;
      }
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "none of the points")) << Said(findings);
}

TEST(CheckScene, FindsCamerasInOneSpot) {
  Scene scene;
  for (Json& frame : scene.json["frames"])
    for (int row = 0; row < 3; ++row) frame["transform_matrix"][row][3] = 0.25;
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "in one spot")) << Said(findings);
}

TEST(CheckScene, FindsTestImagesThatAreTrainingImages) {
  const Scene scene;
  Image8 copy = ReadImage(scene.folder / scene.Frame(1));
  for (const int noise : {0, 3}) {  // 3: as of JPEG
    for (size_t i = 0; i < copy.data.size(); ++i)
      copy.data[i] = uint8_t(copy.data[i] + (i % 2 ? noise : -noise));
    WriteImage(scene.folder / scene.Frame(0), copy);
    const auto findings = CheckScene(scene.Load({1, true, false}));
    EXPECT_TRUE(Wrong(findings, "test images are training images")) << Said(findings);
  }
}

// Too many for all images to be looked at.
TEST(CheckScene, FindsTestPosesThatAreTrainingPoses) {
  Scene scene(60);
  ASSERT_EQ(scene.Load({1, true, false}).test[3].name, "images/30.png");
  scene.json["frames"][30]["transform_matrix"] = scene.json["frames"][1]["transform_matrix"];
  EXPECT_FALSE(AnyWrong(CheckScene(scene.Load({1, true, false})))) << "as if the light had changed";
  WriteImage(scene.folder / "images/30.png", ReadImage(scene.folder / "images/1.png"));
  const auto findings = CheckScene(scene.Load({1, true, false}));
  EXPECT_TRUE(Wrong(findings, "1 test images are training images")) << Said(findings);
}

TEST(CheckScene, FindsIntrinsicsOfNoPhotograph) {
  const struct {
    const char* field;
    double value;
    const char* said;
  } cases[] = {{"cx", -3, "outside of the image"},
               {"cx", 2 * NerfScene::kWidth, "outside of the image"},
               {"fl_y", NerfScene::kFocal / 2, "not so far from square"},
               {"fl_x", 0.9, "would see 177 degrees"}};
  for (const auto& c : cases) {
    Scene scene;
    scene.json[c.field] = c.value;
    if (c.value == 0.9) scene.json["fl_y"] = 0.9;
    const auto findings = CheckScene(scene.Load());
    EXPECT_TRUE(Wrong(findings, c.said)) << c.field << ": " << Said(findings);
    EXPECT_TRUE(Wrong(findings, "24 of 24 cameras")) << Said(findings);
  }
  for (const double center : {0.0, 0.5}) {  // of the image, as some programs write it
    Scene scene;
    scene.json["cx"] = scene.json["cy"] = center;
    const auto findings = CheckScene(scene.Load());
    EXPECT_TRUE(Wrong(findings, "in the image's corner")) << Said(findings);
    EXPECT_FALSE(Wrong(findings, "mirrored")) << Said(findings);
  }
}

TEST(CheckScene, SaysThatFocalLengthsAreMixed) {
  Scene scene;
  for (size_t i = 0; i < scene.json["frames"].size(); i += 3) {
    Json& frame = scene.json["frames"][i];
    frame["fl_x"] = frame["fl_y"] = 1.1 * NerfScene::kFocal;
  }
  EXPECT_EQ(Said(CheckScene(scene.Load())).find("another focal length"), std::string::npos);
  for (size_t i = 0; i < scene.json["frames"].size(); i += 3) {
    Json& frame = scene.json["frames"][i];
    frame["fl_x"] = frame["fl_y"] = 1.5 * NerfScene::kFocal;
  }
  const std::string said = Said(CheckScene(scene.Load()));
  EXPECT_NE(said.find("8 of 24 cameras have another focal length"), std::string::npos) << said;
}

TEST(CheckScene, FindsACameraFarFromTheOthers) {
  for (const double x : {40.0, 1e4, -1e30}) {
    Scene scene;
    scene.json["frames"][5]["transform_matrix"][0][3] = x;
    const std::vector<Finding> findings = CheckScene(scene.Load());
    const std::string said = Said(findings);
    EXPECT_NE(said.find("1 of 24 cameras are far from the others, images/5.png"), std::string::npos)
        << said;
    EXPECT_EQ(Wrong(findings, "far from the others"), x != 40.0) << said;
  }
}

TEST(CheckScene, FindsOneFileUnderManyCameras) {
  Scene scene;
  scene.json["frames"][3]["file_path"] = scene.json["frames"][9]["file_path"];
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "1 of 24 views have the image of another one")) << Said(findings);
}

// Of renderings, whose corners are empty: transparent, black or white.
TEST(CheckScene, FindsOtherBackgroundsOfTestImages) {
  enum { kAlpha, kBlack, kWhite };
  const auto said = [](int training, int held_out) {
    const Scene scene;
    ChangeImages(scene, [&](int i, Image8& image) {
      const bool is_test = i == 0 || i == 16 || i == 23;  // by name
      const int kind = is_test ? held_out : training;
      Image8 made(image.width, image.height, kind == kAlpha ? 4 : 3);
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
          const bool inside = x > 8 && x < image.width - 8 && y > 8 && y < image.height - 8;
          for (int c = 0; c < 3; ++c)
            made.at(x, y, c) = inside ? image.at(x, y, c) : kind == kWhite ? 255 : 0;
          if (kind == kAlpha) made.at(x, y, 3) = inside ? 255 : 0;
        }
      image = made;
    });
    return Said(CheckScene(scene.Load({1, true, false})));
  };
  for (const int kind : {kAlpha, kBlack, kWhite})
    EXPECT_EQ(said(kind, kind).find("background"), std::string::npos) << said(kind, kind);
  for (const auto& [a, b] :
       {std::pair(kAlpha, kBlack), {kWhite, kAlpha}, {kBlack, kWhite}, {kWhite, kBlack}})
    EXPECT_NE(said(a, b).find("different backgrounds"), std::string::npos) << said(a, b);
}

TEST(CheckScene, FindsMasksThatLeaveNothing) {
  const Scene scene;
  MakeDirectories(scene.folder / "masks");
  for (int i = 0; i < 24; ++i)
    WriteImage(scene.folder / ("masks/" + std::to_string(i) + ".png"),
               Image8(NerfScene::kWidth, NerfScene::kHeight, 1, i == 0 ? 255 : 0));
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "black everywhere")) << Said(findings);
}

TEST(CheckScene, FindsImagesWithoutContent) {
  const Scene scene;
  ChangeImages(scene, [](int, Image8& image) {
    std::fill(image.data.begin(), image.data.end(), uint8_t(90));
  });
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "nearly of one colour")) << Said(findings);
}

TEST(CheckScene, FindsAlphaOfZero) {
  const Scene scene;
  ChangeImages(scene, [](int, Image8& image) { image = Image8(image.width, image.height, 4); });
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "transparent everywhere")) << Said(findings);
}

TEST(CheckScene, FindsOneImageUnderManyNames) {
  const Scene scene;
  const Image8 one = ReadImage(scene.folder / scene.Frame(3));
  ChangeImages(scene, [&](int, Image8& image) { image = one; });
  const auto findings = CheckScene(scene.Load());
  EXPECT_TRUE(Wrong(findings, "of the view before")) << Said(findings);
}

// At a glance its images are alike; test views beside training views are no copies.
TEST(CheckScene, AThinThingThatHardlyMovesIsNotOneImage) {
  const Scene scene;
  ChangeImages(scene, [](int i, Image8& image) {
    image = Image8(image.width, image.height, 4);
    for (int y = 0; y < image.height; ++y) {
      for (int c = 0; c < 3; ++c) image.at(16 + i, y, c) = 60;
      image.at(16 + i, y, 3) = 255;
      image.at(16 + i, y / 2, 0) = 200;
    }
  });
  for (const bool eval : {false, true}) {
    const auto findings = CheckScene(scene.Load({1, eval, false}));
    EXPECT_FALSE(Wrong(findings, "of the view before")) << Said(findings);
    EXPECT_FALSE(Wrong(findings, "test images are training images")) << Said(findings);
  }
}

// Published scenes, where they are: right as they are, and wrong once one thing is broken.
class CheckRealScene : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string folder = COSPLAT_SOURCE_DIR "/../shared/data/" + std::string(GetParam());
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are not here";
    SceneOptions options;
    options.eval = true;
    if (std::filesystem::exists(folder + "/images_8")) options.resolution = 8;
    scene_ = LoadScene(folder, options);
  }
  void ChangeViews(const std::function<void(SceneView&)>& change) {
    for (std::vector<SceneView>* list : {&scene_.train, &scene_.test})
      for (SceneView& view : *list) change(view);
  }
  // Each view with the image of the one `by` places further on, by name.
  void ShiftImages(size_t by) {
    std::vector<SceneView*> views;
    ChangeViews([&](SceneView& view) { views.push_back(&view); });
    std::sort(views.begin(), views.end(), [](const SceneView* a, const SceneView* b) {
      return a->name < b->name;
    });
    std::vector<std::string> images;
    for (const SceneView* view : views) images.push_back(view->image_path);
    for (size_t i = 0; i < views.size(); ++i)
      views[i]->image_path = images[(i + by) % images.size()];
  }
  SceneData scene_;
};

TEST_P(CheckRealScene, AsItIs) { EXPECT_EQ(Said(CheckScene(scene_)), ""); }
TEST_P(CheckRealScene, ImagesOfTheNextView) {
  if (scene_.points.empty()) GTEST_SKIP() << "silhouettes of neighbours fit each other";
  ShiftImages(1);
  EXPECT_TRUE(AnyWrong(CheckScene(scene_))) << Said(CheckScene(scene_));
}
TEST_P(CheckRealScene, ImagesOfOtherViews) {
  ShiftImages(11);
  EXPECT_TRUE(AnyWrong(CheckScene(scene_))) << Said(CheckScene(scene_));
}
TEST_P(CheckRealScene, FocalLengths) {
  if (scene_.points.empty()) GTEST_SKIP() << "silhouettes fit each other at any focal length";
  for (const float factor : {0.5f, 0.7f, 1.4f, 2.0f}) {
    const SceneData right = scene_;
    ChangeViews([&](SceneView& view) {
      view.camera.fx *= factor, view.camera.fy *= factor;
      view.file_camera.fx *= factor, view.file_camera.fy *= factor;
    });
    EXPECT_TRUE(AnyWrong(CheckScene(scene_))) << factor << ": " << Said(CheckScene(scene_));
    scene_ = right;
  }
}
TEST_P(CheckRealScene, OtherAxes) {
  ChangeViews([](SceneView& view) {
    for (int k = 3; k < 9; ++k) view.camera.rotation[size_t(k)] *= -1;
    for (int k = 1; k < 3; ++k) view.camera.translation[size_t(k)] *= -1;
  });
  EXPECT_TRUE(AnyWrong(CheckScene(scene_))) << Said(CheckScene(scene_));
}
TEST_P(CheckRealScene, InvertedPoses) {
  ChangeViews([](SceneView& view) {
    const std::array<float, 9> r = view.camera.rotation;
    view.camera.translation = view.camera.Center();
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) view.camera.rotation[size_t(3 * i + k)] = r[size_t(3 * k + i)];
  });
  EXPECT_TRUE(AnyWrong(CheckScene(scene_))) << Said(CheckScene(scene_));
}
TEST_P(CheckRealScene, CamerasInOtherUnits) {
  ChangeViews([](SceneView& view) {
    for (float& t : view.camera.translation) t *= 3;
  });
  if (scene_.points.empty()) GTEST_SKIP() << "silhouettes fit each other in any unit";
  EXPECT_TRUE(AnyWrong(CheckScene(scene_))) << Said(CheckScene(scene_));
}
INSTANTIATE_TEST_SUITE_P(Shared, CheckRealScene, testing::Values("fox", "garden", "chair", "mic"));

}  // namespace
}  // namespace cosplat::test
