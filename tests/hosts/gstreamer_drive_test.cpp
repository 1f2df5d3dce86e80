// cosplatsrc with a face that moves.
#include "tests/hosts/gstreamer_fixture.h"
#include "tests/support/stand_in_webcam.h"

namespace cosplat::test {
namespace {

std::string Driven(const std::string& drive, const std::string& properties) {
  return "cosplatsrc name=src " + AvatarProperties() + " width=64 height=64 drive=" + drive + " " +
         properties;
}

TEST(CosplatSrcDrive, ShowsTheFaceAtTheFramesTime) {
  const std::string drive = WriteRecording(12, 25);
  Pipeline pipeline(Driven(drive, "fps=25"));
  const std::vector<PulledFrame> frames = pipeline.PlayAll();
  ASSERT_EQ(frames.size(), 12u);  // then the recording and with it the stream are over
  const OpenAvatar avatar;
  ASSERT_EQ(cosplat_set_drive(avatar, drive.c_str()), COSPLAT_OK);
  int moves = 0;
  std::vector<uint8_t> last;
  for (const PulledFrame& frame : frames) {
    ASSERT_EQ(cosplat_advance(avatar, int64_t(frame.pts)), COSPLAT_OK);
    EXPECT_EQ(frame.bytes, Draw(avatar, {64, 64})) << frame.pts;
    moves += frame.bytes != last;
    last = frame.bytes;
  }
  EXPECT_GT(moves, 6);
  EXPECT_EQ(pipeline.Error(0), "");
}

TEST(CosplatSrcDrive, GoesOnWhereRecordingsLoopOrTheStreamIsLive) {
  const std::string drive = WriteRecording(5, 200);
  for (const std::string properties : {"loop=true fps=200", "is-live=true fps=200"}) {
    Pipeline pipeline(Driven(drive, properties + " num-buffers=17"));
    EXPECT_EQ(pipeline.PlayAll().size(), 17u) << properties;
  }
}

TEST(CosplatSrcDrive, CountsWhatCame) {
  Pipeline pipeline(Driven(WriteRecording(6, 25), "fps=25"));
  EXPECT_EQ(pipeline.PlayAll().size(), 6u);
  GstStructure* stats = nullptr;
  g_object_get(pipeline.Named("src"), "stats", &stats, nullptr);
  ASSERT_NE(stats, nullptr);
  for (const char* name : {"frames", "drive-frames", "accepted"}) {
    guint64 count = 0;
    EXPECT_TRUE(gst_structure_get_uint64(stats, name, &count)) << name;
    EXPECT_EQ(count, 6u) << name;
  }
  EXPECT_NE(std::string(gst_structure_get_string(stats, "drive")).find("talk.npz"),
            std::string::npos);
  gst_structure_free(stats);
}

TEST(CosplatSrcDrive, AWebcamIsTheCommandBesideThePipeline) {
  const StandInWebcam webcam;
  Pipeline pipeline(Driven("webcam:1", "is-live=true fps=25 num-buffers=50"));
  const std::vector<PulledFrame> frames = pipeline.PlayAll();
  ASSERT_EQ(frames.size(), 50u);
  EXPECT_NE(frames.back().bytes, frames.front().bytes);
}

TEST(CosplatSrcDrive, ALiveOneInAPipelineThatIsNotIsWarnedOf) {
  Pipeline wrong(Driven("udp://127.0.0.1:0", "num-buffers=2"));
  EXPECT_EQ(wrong.PlayAll().size(), 2u);
  EXPECT_NE(wrong.Warning(GST_SECOND).find("is-live=false"), std::string::npos);
  Pipeline live(Driven("udp://127.0.0.1:0", "is-live=true fps=50 num-buffers=2"));
  EXPECT_EQ(live.PlayAll().size(), 2u);
  EXPECT_EQ(live.Warning(0), "");
}

TEST(CosplatSrcDrive, ABadOneIsAnErrorInTheLibrarysWords) {
  const OpenAvatar avatar;
  for (const std::string drive : {"/no/such.npz", "udp://nowhere:x"}) {
    Pipeline pipeline(Driven(drive, ""));
    gst_element_set_state(pipeline.element(), GST_STATE_PLAYING);
    EXPECT_EQ(cosplat_set_drive(avatar, drive.c_str()), COSPLAT_ERROR_DRIVE);
    EXPECT_EQ(pipeline.Error(10 * GST_SECOND), cosplat_last_error(avatar));
  }
}

}  // namespace
}  // namespace cosplat::test
