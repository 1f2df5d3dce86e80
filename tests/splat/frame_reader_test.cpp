// Frames that are not kept in memory: training sees the same as if they were.
#include "splat/train/subject/frame_reader.h"

#include <gtest/gtest.h>

#include <atomic>

#include "splat/media/image_io.h"
#include "splat/train/subject/reduced_frames.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small scenes

// The frames with the images of all but the first `kept` read on demand; `reads` counts that.
std::vector<TrainFrame> OnDemand(const std::vector<TrainFrame>& frames,
                                 size_t kept,
                                 std::atomic<int>& reads) {
  std::vector<TrainFrame> result = frames;
  for (size_t i = kept; i < frames.size(); ++i) {
    const auto read = [&frames, &reads, i] {
      ++reads;
      return frames[i];
    };
    result[i] = {frames[i].camera, {}, {}, read};
  }
  return result;
}

TEST(FrameReader, TrainingHasTheSameBits) {
  std::vector<TrainFrame> frames = TargetImages(TrueScene(1), Ring(6, 2.2f, 208), true);
  frames[3].ignored = Image8(208, 208, 1, 255);
  TrainSettings settings = ShortRun(60, 1);
  settings.schedule.num_downscales = 1;
  settings.schedule.downscale_every = 25;
  for (const int batch : {1, 4}) {
    settings.batch = batch;
    SceneSubject in_memory(frames, 1);
    const TrainingState all = Train(settings, in_memory, FirstGaussians(60, 1), 60 / batch);
    std::atomic<int> reads = 0;
    SceneSubject on_demand(OnDemand(frames, 2, reads), 1);
    on_demand.LimitReduced(2 * 104 * 104 * 4);
    EXPECT_TRUE(SameBits(all, Train(settings, on_demand, FirstGaussians(60, 1), 60 / batch)));
    EXPECT_GT(reads, 20) << "batch " << batch;
    EXPECT_LE(reads, 60 + 6) << "a view is read once a step; batch " << batch;
  }
}

TEST(FrameReader, ReadsAhead) {
  const std::vector<TrainFrame> frames = TargetImages(TrueScene(1), Ring(3, 2.2f));
  std::atomic<int> reads = 0;
  const std::vector<TrainFrame> lazy = OnDemand(frames, 1, reads);
  FrameReader reader;
  EXPECT_EQ(&reader.At(lazy[0]), &lazy[0]);
  reader.Expect(lazy[0]);
  EXPECT_EQ(reads, 0);
  reader.Expect(lazy[1]);
  EXPECT_EQ(reader.At(lazy[1]).target.data, frames[1].target.data);
  EXPECT_EQ(reader.At(lazy[1]).target.data, frames[1].target.data);
  EXPECT_EQ(reads, 1);
  reader.Expect(lazy[2]);  // in vain
  EXPECT_EQ(reader.At(lazy[1]).target.data, frames[1].target.data);
  EXPECT_EQ(reader.At(lazy[2]).target.data, frames[2].target.data);
  EXPECT_EQ(reads, 2);
}

TEST(FrameReader, AFileThatVanishedIsNamed) {
  const TemporaryFolder folder;
  std::vector<SceneView> views(3);
  for (size_t i = 0; i < views.size(); ++i) {
    SceneView& view = views[i];
    view.name = std::to_string(i);
    view.image_path = folder / (view.name + ".png");
    view.camera = view.file_camera = LookingAt({0, 0, 3}, {0, 0, 0}, 20);
    WriteImage(view.image_path, Image8(20, 20, 3, uint8_t(i)));
  }
  std::vector<SkippedFrame> skipped;
  const std::vector<TrainFrame> frames =
      LoadTrainFrames(views, skipped, 2 * ImageBytes(views[0].camera));
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_FALSE(frames[1].target.empty());
  EXPECT_TRUE(frames[2].target.empty());
  TrainFrame scratch;
  EXPECT_EQ(Loaded(frames[2], scratch).target.data, std::vector<uint8_t>(1200, 2));
  std::filesystem::remove(views[2].image_path);
  ExpectError([&] { Loaded(frames[2], scratch); }, {"2.png"});
  FrameReader reader;
  reader.Expect(frames[2]);
  ExpectError([&] { reader.At(frames[2]); }, {"2.png"});
}

}  // namespace
}  // namespace cosplat
