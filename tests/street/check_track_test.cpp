// CheckTrack on the procedural head's video, and on the same with one thing broken.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "assets/head/video.h"
#include "flame/model.h"
#include "flame/track.h"
#include "tests/street/findings.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

// 60 frames of 128 px, in memory.
class CheckTrackOf : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    MakeHeadOptions options;
    options.frames = 60, options.test_frames = 10, options.size = 128;
    WriteProceduralVideo(folder_->path(), options);
  }
  static void TearDownTestSuite() { delete folder_; }

  CheckTrackOf() : flame_(LoadFlameModel(*folder_ / "model.npz")) {
    video_ = LoadTrackedVideo(folder_->path(), {-1, 1, &flame_});
    for (TrackedFrame* frame : FramesInOrder(video_))
      frame->image = std::make_shared<Image8>(LoadTrackedImage(video_, *frame));
  }
  std::vector<Finding> Check() const { return CheckTrack(flame_, video_); }
  void Change(const std::function<void(Image8&)>& change) {
    for (TrackedFrame* frame : FramesInOrder(video_)) {
      Image8 image = *frame->image;
      change(image);
      frame->image = std::make_shared<Image8>(std::move(image));
    }
  }

  static TemporaryFolder* folder_;
  FlameModel flame_;
  TrackedVideo video_;
};
TemporaryFolder* CheckTrackOf::folder_ = nullptr;

TEST_F(CheckTrackOf, GoodDataSaysNothing) { EXPECT_EQ(Said(Check()), ""); }

TEST_F(CheckTrackOf, ImagesUpsideDown) {
  Change([](Image8& image) {
    const Image8 old = image;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < image.channels; ++c)
          image.at(x, y, c) = old.at(image.width - 1 - x, image.height - 1 - y, c);
  });
  EXPECT_TRUE(Wrong(Check(), "upside down")) << Said(Check());
}

// Mirrored, most of the head's points would be where the mask is empty, or on a wall.
TEST_F(CheckTrackOf, AHeadAsideOfTheMiddle) {
  constexpr int kAside = 60;  // px
  const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
  std::vector<std::shared_ptr<const Image8>> images;
  for (TrackedFrame* frame : frames) {
    images.push_back(frame->image);
    frame->camera.width += kAside;
    frame->camera.cx += kAside;
  }
  for (const uint8_t wall : {uint8_t(0), uint8_t(150)}) {
    for (size_t f = 0; f < frames.size(); ++f) {
      const Image8& old = *images[f];
      Image8 image(old.width + kAside, old.height, wall > 0 ? 3 : 4);
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
          for (int c = 0; c < image.channels; ++c) {
            const bool is_head = x >= kAside && old.at(x - kAside, y, 3) > 127;
            image.at(x, y, c) = is_head ? old.at(x - kAside, y, c) : wall;
          }
      frames[f]->image = std::make_shared<Image8>(std::move(image));
    }
    EXPECT_EQ(Said(Check()), "") << int(wall);
  }
}

TEST_F(CheckTrackOf, ImagesOfOtherMoments) {
  for (const int shift : {-3, 3}) {
    const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
    std::vector<std::shared_ptr<const Image8>> images;
    for (const TrackedFrame* frame : frames) images.push_back(frame->image);
    for (int i = 0; i < int(frames.size()); ++i)
      frames[size_t(i)]->image = images[size_t(std::clamp(i + shift, 0, int(images.size()) - 1))];
    EXPECT_TRUE(Wrong(Check(), "do not agree in time")) << shift << ": " << Said(Check());
    for (size_t i = 0; i < frames.size(); ++i) frames[i]->image = images[i];
  }
}

// A codec shows a still head a little differently in each frame, and more so at first.
TEST_F(CheckTrackOf, AStillHeadIsOfAnyMoment) {
  const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
  const Image8 still = *frames[0]->image;
  for (size_t f = 0; f < frames.size(); ++f) {
    frames[f]->params = frames[0]->params;
    frames[f]->camera = frames[0]->camera;
    Image8 image = still;
    for (size_t i = 0; i < image.data.size(); ++i)
      if (image.data[i] < 254) image.data[i] += uint8_t((f < 8) + (i % 60 == f));
    frames[f]->image = std::make_shared<Image8>(std::move(image));
  }
  EXPECT_EQ(Said(Check()), "");
}

// As of a track that names one file of parameters for all.
TEST_F(CheckTrackOf, OneFaceForAllImages) {
  const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
  for (TrackedFrame* frame : frames) {
    frame->params = frames[0]->params;
    frame->camera = frames[0]->camera;
  }
  EXPECT_TRUE(Wrong(Check(), "all 60 frames have the same pose and expression")) << Said(Check());
}

TEST_F(CheckTrackOf, TestFramesThatAreTrainingFrames) {
  const TrackedVideo right = video_;
  video_.test[3].image_path = video_.train[7].image_path;
  EXPECT_TRUE(Wrong(Check(), "1 of 10 test frames are training frames")) << Said(Check());
  video_ = right;
  for (size_t i = 0; i < 4; ++i) {  // copied under other names
    const TrackedFrame& train = video_.train[5 * i];
    video_.test[i].params = train.params;
    video_.test[i].camera = train.camera;
    video_.test[i].image = train.image;
  }
  EXPECT_TRUE(Wrong(Check(), "4 of 10 test frames are training frames")) << Said(Check());
}

TEST_F(CheckTrackOf, AHeadOnItsSide) {
  for (TrackedFrame* frame : FramesInOrder(video_)) {  // with its camera
    const Camera old = frame->camera;
    for (size_t k = 0; k < 3; ++k) {
      frame->camera.rotation[k] = -old.rotation[3 + k];
      frame->camera.rotation[3 + k] = old.rotation[k];
    }
    frame->camera.translation[0] = -old.translation[1];
    frame->camera.translation[1] = old.translation[0];
  }
  EXPECT_TRUE(Wrong(Check(), "on its side or upside down in 60 of 60")) << Said(Check());
}

TEST_F(CheckTrackOf, IntrinsicsOfNoVideo) {
  for (TrackedFrame* frame : FramesInOrder(video_)) frame->camera.cx = frame->camera.cy = 0.5f;
  EXPECT_TRUE(Wrong(Check(), "in the image's corner")) << Said(Check());
}

TEST_F(CheckTrackOf, FewFrames) {
  video_.train.resize(4);
  EXPECT_NE(Said(Check()).find("note: 4 training frames:"), std::string::npos) << Said(Check());
}

TEST_F(CheckTrackOf, MasksThatHoldAllOfSomeImages) {
  const TrackedVideo right = video_;
  const auto open = [](TrackedFrame& frame) {
    Image8 image = *frame.image;
    for (size_t i = 0; i < image.pixels(); ++i) image.data[4 * i + 3] = 255;
    frame.image = std::make_shared<Image8>(std::move(image));
  };
  for (size_t i = 0; i < video_.train.size(); ++i)
    if (i % 8 < 4) open(video_.train[i]);
  EXPECT_TRUE(Wrong(Check(), "the background is not cut out")) << Said(Check());
  video_ = right;
  for (TrackedFrame& frame : video_.test) open(frame);
  EXPECT_TRUE(Wrong(Check(), "look at the masks of the test frames")) << Said(Check());
}

TEST_F(CheckTrackOf, HeadOutsideOfTheImage) {
  for (TrackedFrame* frame : FramesInOrder(video_)) frame->camera.cx += 200;
  EXPECT_TRUE(Wrong(Check(), "inside the image")) << Said(Check());
}

TEST_F(CheckTrackOf, MasksElsewhere) {
  Change([](Image8& image) {
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) image.at(x, y, 3) = x < 20 && y > 100 ? 255 : 0;
  });
  EXPECT_TRUE(Wrong(Check(), "the masks hold only")) << Said(Check());
}

// Around the skull, as high as a third of the head.
TEST_F(CheckTrackOf, ThickHair) {
  Change([](Image8& image) {
    const Image8 old = image;
    const auto is_head = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < old.width && y < old.height && old.at(x, y, 3) > 127;
    };
    int top = 0;
    const auto is_empty = [&](int y) {
      for (int x = 0; x < old.width; ++x)
        if (is_head(x, y)) return false;
      return true;
    };
    while (is_empty(top)) ++top;
    for (int y = 0; y < top + 24; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int v = y; v <= std::min(y + 24, top + 23); ++v)
          for (int u = x - 8; u <= x + 8; ++u)
            if (is_head(u, v)) image.at(x, y, 3) = 255;
  });
  EXPECT_EQ(Said(Check()), "");
}

TEST_F(CheckTrackOf, MasksOfNothing) {
  Change([](Image8& image) {
    for (size_t i = 3; i < image.data.size(); i += 4) image.data[i] = 0;
  });
  EXPECT_TRUE(Wrong(Check(), "mask shows nothing")) << Said(Check());
}

TEST_F(CheckTrackOf, OneImageForAllFrames) {
  const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
  for (TrackedFrame* frame : frames) frame->image = frames[0]->image;
  EXPECT_TRUE(Wrong(Check(), "of the frame before")) << Said(Check());
}

// One is missing, one is cut off: what is left is judged.
TEST_F(CheckTrackOf, ImagesThatCannotBeRead) {
  const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
  const std::string cut = *folder_ / "cut.png";
  std::filesystem::copy_file(
      frames[0]->image_path, cut, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(cut, 100);
  for (size_t i = 0; i < 12; ++i) {
    frames[i]->image.reset();
    frames[i]->image_path = i == 0 ? *folder_ / "none.png" : cut;
  }
  SettleMasks(flame_, video_);
  const std::vector<Finding> some = Check();
  ASSERT_EQ(some.size(), 1u) << Said(some);
  EXPECT_FALSE(some.front().wrong);
  EXPECT_NE(some.front().text.find("frames looked at cannot be used and are left out"),
            std::string::npos)
      << Said(some);
  for (size_t i = 0; i < 30; ++i) frames[i]->image.reset(), frames[i]->image_path = cut;
  EXPECT_TRUE(Wrong(Check(), "cannot be used")) << Said(Check());
  for (TrackedFrame* frame : frames) frame->image.reset(), frame->image_path = cut;
  EXPECT_THROW(Check(), Error);
}

TEST_F(CheckTrackOf, ImagesOfOneColour) {
  Change([](Image8& image) {
    for (size_t i = 0; i < image.data.size(); ++i)
      if (i % 4 != 3) image.data[i] = 80;
  });
  EXPECT_TRUE(Wrong(Check(), "nearly of one colour")) << Said(Check());
}

TEST_F(CheckTrackOf, ExpressionsOfAnotherModel) {
  for (TrackedFrame* frame : FramesInOrder(video_)) {
    frame->params.expression.resize(size_t(flame_.expression_count) + 5, 0.5f);
    frame->params.expression[0] = 9;
  }
  EXPECT_TRUE(Wrong(Check(), "beyond 6 standard deviations")) << Said(Check());
  EXPECT_NE(Said(Check()).find("expression coefficients"), std::string::npos);
}

// Hair all around the head, and as far from it as an eighth of the image.
void AddMane(Image8& image) {
  for (const bool along_rows : {true, false}) {
    const Image8 old = image;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (const int side : {-1, 1})
          for (int k = 1; old.at(x, y, 3) > 127 && k <= image.width / 8; ++k) {
            const int u = x + side * k * along_rows, v = y + side * k * !along_rows;
            const bool is_outside = u < 0 || v < 0 || u >= image.width || v >= image.height;
            if (is_outside || old.at(u, v, 3) > 127) break;
            for (int c = 0; c < 3; ++c) image.at(u, v, c) = uint8_t(60 + (7 * u + 13 * v) % 20);
            image.at(u, v, 3) = 255;
          }
  }
}

TEST_F(CheckTrackOf, AMane) {
  Change(AddMane);
  EXPECT_EQ(Said(Check()), "");
}

// Real heads, where they are.
class CheckRealTrack : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string folder = COSPLAT_SOURCE_DIR "/../shared/data/tracked/";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are not here";
    flame_ = LoadFlameModel(folder + "flame_for_tracks.npz");
    video_ = LoadTrackedVideo(folder + GetParam(), {-1, 1, &flame_});
  }
  std::vector<Finding> Check() const { return CheckTrack(flame_, video_); }
  void ShiftImages(int by) {
    const std::vector<TrackedFrame*> frames = FramesInOrder(video_);
    std::vector<TrackedFrame> old;
    for (const TrackedFrame* frame : frames) old.push_back(*frame);
    for (int i = 0; i < int(frames.size()); ++i) {
      *frames[size_t(i)] = old[size_t(std::clamp(i + by, 0, int(old.size()) - 1))];
      frames[size_t(i)]->params = old[size_t(i)].params;
    }
  }
  void ChangeImages(const std::function<void(Image8&)>& change) {
    for (TrackedFrame* frame : FramesInOrder(video_)) {
      Image8 image = LoadTrackedImage(video_, *frame);
      change(image);
      frame->image = std::make_shared<Image8>(std::move(image));
    }
  }
  FlameModel flame_;
  TrackedVideo video_;
};

void Mirror(Image8& image, bool x, bool y) {
  const Image8 old = image;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u)
      for (int c = 0; c < image.channels; ++c)
        image.at(u, v, c) = old.at(x ? image.width - 1 - u : u, y ? image.height - 1 - v : v, c);
}

TEST_P(CheckRealTrack, AsItIs) { EXPECT_EQ(Said(Check()), ""); }
TEST_P(CheckRealTrack, ImagesOfOtherMoments) {
  const TrackedVideo right = video_;
  for (const int by : {-1, 1, 2}) {
    ShiftImages(by);
    EXPECT_TRUE(AnyWrong(Check())) << by << ": " << Said(Check());
    video_ = right;
  }
}
TEST_P(CheckRealTrack, ImagesUpsideDown) {
  ChangeImages([](Image8& image) { Mirror(image, true, true); });
  EXPECT_TRUE(AnyWrong(Check())) << Said(Check());
}
TEST_P(CheckRealTrack, ImagesMirrored) {
  ChangeImages([](Image8& image) { Mirror(image, true, false); });
  EXPECT_TRUE(AnyWrong(Check())) << Said(Check());
}
TEST_P(CheckRealTrack, FocalLengths) {
  const TrackedVideo right = video_;
  for (const float factor : {0.7f, 1.5f}) {
    for (TrackedFrame* frame : FramesInOrder(video_))
      frame->camera.fx *= factor, frame->camera.fy *= factor;
    EXPECT_TRUE(AnyWrong(Check())) << factor << ": " << Said(Check());
    video_ = right;
  }
}
TEST_P(CheckRealTrack, HeadsElsewhere) {
  for (TrackedFrame* frame : FramesInOrder(video_)) frame->camera.cx += 60;  // of 512 px
  EXPECT_TRUE(AnyWrong(Check())) << Said(Check());
}
TEST_P(CheckRealTrack, AMane) {
  ChangeImages(AddMane);
  EXPECT_EQ(Said(Check()), "");
}
INSTANTIATE_TEST_SUITE_P(Shared, CheckRealTrack, testing::Values("wojtek_vhap", "speaker_vhap"));

}  // namespace
}  // namespace cosplat::test
