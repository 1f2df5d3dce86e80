// cosplatsrc in pipelines without a codec: the library's own pictures, at the right times, through
// every change of state.
#include <gst/controller/gstdirectcontrolbinding.h>
#include <gst/controller/gstinterpolationcontrolsource.h>

#include "tests/hosts/gstreamer_fixture.h"

namespace cosplat::test {
namespace {

std::string Source(const std::string& properties = "") {
  return "cosplatsrc name=src " + AvatarProperties() + " " + properties;
}

TEST(CosplatSrc, GivesTheLibrarysPictures) {
  struct Case {
    std::string properties, format;
    Wanted wanted;
  };
  const std::vector<Case> cases = {
      {"", "RGBA", {}},
      {"background=transparent azimuth=30 elevation=-10 zoom=1.5",
       "RGBA",
       {512, 512, 30, -10, 1.5f, COSPLAT_FORMAT_RGBA8, COSPLAT_ALPHA_STRAIGHT}},
      {"background=#ff8000 width=97 height=53",
       "BGRA",
       {97, 53, 0, 0, 1, COSPLAT_FORMAT_BGRA8, COSPLAT_ALPHA_OPAQUE, {1, 128.0f / 255, 0}}}};
  for (const Case& c : cases) {
    Pipeline pipeline(Source(c.properties + " num-buffers=2") +
                      " ! video/x-raw,format=" + c.format);
    const std::vector<uint8_t> expected = Draw(c.wanted);
    const std::vector<PulledFrame> frames = pipeline.PlayAll();
    ASSERT_EQ(frames.size(), 2u);
    for (const PulledFrame& frame : frames) {
      EXPECT_EQ(uint32_t(frame.width), c.wanted.width);
      EXPECT_EQ(uint32_t(frame.height), c.wanted.height);
      EXPECT_EQ(frame.bytes, expected) << c.properties;
    }
  }
}

TEST(CosplatSrc, SizeAndRateAreDownstreamsWhereItHasAWish) {
  Pipeline pipeline(Source("num-buffers=31 width=640 fps=5") +
                    " ! video/x-raw,width=48,height=64,framerate=30000/1001");
  const std::vector<PulledFrame> frames = pipeline.PlayAll();
  ASSERT_EQ(frames.size(), 31u);
  for (size_t n = 0; n < frames.size(); ++n) {
    EXPECT_EQ(frames[n].width, 48);
    EXPECT_EQ(frames[n].height, 64);
    EXPECT_EQ(frames[n].pts, n * 1001 * GST_SECOND / 30000);
    EXPECT_EQ(frames[n].pts + frames[n].duration, (n + 1) * 1001 * GST_SECOND / 30000);
  }
  Pipeline free(Source("num-buffers=1 width=40 height=30 fps=5"));
  const std::vector<PulledFrame> own = free.PlayAll();
  ASSERT_EQ(own.size(), 1u);
  EXPECT_EQ(own[0].width, 40);
  EXPECT_EQ(own[0].height, 30);
  EXPECT_EQ(own[0].duration, GST_SECOND / 5);
}

TEST(CosplatSrc, BeginsAnewEveryTime) {
  const std::vector<uint8_t> expected = Draw({64, 64});
  for (const bool live : {false, true}) {
    Pipeline pipeline(Source("width=64 height=64 fps=100 is-live=") + (live ? "true" : "false"));
    for (int round = 0; round < 10; ++round) {
      // Live sources give nothing before they play.
      if (round % 3 == 1) {
        ASSERT_TRUE(pipeline.Set(GST_STATE_PAUSED));
      }
      ASSERT_TRUE(pipeline.Set(GST_STATE_PLAYING));
      PulledFrame frame;
      ASSERT_TRUE(pipeline.Pull(frame));
      // An appsink keeps what it holds while its pipeline is READY.
      for (int held = 0; !live && frame.pts != 0 && held < 2; ++held)
        ASSERT_TRUE(pipeline.Pull(frame));
      EXPECT_EQ(frame.bytes, expected);
      EXPECT_TRUE(live || frame.pts == 0) << round;
      if (round % 2 == 1) {
        ASSERT_TRUE(pipeline.Set(GST_STATE_PAUSED));
      }
      if (round % 4 == 3) {
        EXPECT_TRUE(pipeline.Set(GST_STATE_PLAYING));
        EXPECT_TRUE(pipeline.Pull(frame));
      }
      ASSERT_TRUE(pipeline.Set(round % 2 ? GST_STATE_READY : GST_STATE_NULL));
      EXPECT_EQ(pipeline.Error(0), "");
    }
  }
}

TEST(CosplatSrc, WhatIsWrongIsPostedInTheLibrarysWords) {
  const PluginFiles& files = PluginFiles::Get();
  const auto error_of = [](const std::string& line) {
    Pipeline pipeline(line + " num-buffers=1");
    gst_element_set_state(pipeline.element(), GST_STATE_PLAYING);
    return pipeline.Error(10 * GST_SECOND);
  };
  EXPECT_EQ(error_of("cosplatsrc"), "avatar: none is given; it is the path of a .glb");
  cosplat_avatar* avatar = nullptr;
  cosplat_open_options options = OpenOptions();
  ASSERT_NE(cosplat_open("/nowhere/a.glb", &options, &avatar), COSPLAT_OK);
  EXPECT_EQ(error_of("cosplatsrc avatar=/nowhere/a.glb flame=" + files.flame_path),
            cosplat_last_error(nullptr));
  options.flame_path = nullptr;
  ASSERT_NE(cosplat_open(files.avatar_path.c_str(), &options, &avatar), COSPLAT_OK);
  EXPECT_EQ(error_of("cosplatsrc avatar=" + files.avatar_path), cosplat_last_error(nullptr));
  EXPECT_EQ(error_of(Source("background=blue")),
            "background: 'blue' is not avatar, transparent or #rrggbb");
  EXPECT_EQ(error_of(Source("background=#12345g")),
            "background: '#12345g' is not avatar, transparent or #rrggbb");
  // Larger than any picture may be: 2^26 pixels.
  EXPECT_NE(error_of(Source("width=16384 height=16384")).find("16384"), std::string::npos);
}

TEST(CosplatSrc, ViewAndBackgroundChangeWhileItPlays) {
  Pipeline pipeline(Source("width=64 height=48 background=transparent"));
  ASSERT_TRUE(pipeline.Set(GST_STATE_PLAYING));
  PulledFrame frame;
  ASSERT_TRUE(pipeline.Pull(frame));
  g_object_set(
      pipeline.Named("src"), "azimuth", -45.0, "zoom", 2.0, "background", "#000000", nullptr);
  for (int held = 0; held < 3; ++held) ASSERT_TRUE(pipeline.Pull(frame));
  EXPECT_EQ(frame.bytes, Draw({64, 48, -45, 0, 2, COSPLAT_FORMAT_RGBA8, COSPLAT_ALPHA_OPAQUE, {}}));
}

// In steps: one azimuth from the beginning, another from the third frame on.
TEST(CosplatSrc, TheCameraFollowsAController) {
  Pipeline pipeline(Source("width=64 height=64 fps=25 num-buffers=4"));
  GstControlSource* steps = gst_interpolation_control_source_new();
  g_object_set(steps, "mode", GST_INTERPOLATION_MODE_NONE, nullptr);
  auto* values = GST_TIMED_VALUE_CONTROL_SOURCE(steps);
  gst_timed_value_control_source_set(values, 0, 10);
  gst_timed_value_control_source_set(values, 80 * GST_MSECOND, 45);
  GstObject* source = GST_OBJECT(pipeline.Named("src"));
  gst_object_add_control_binding(source,
                                 gst_direct_control_binding_new_absolute(source, "azimuth", steps));
  gst_object_unref(steps);
  const std::vector<PulledFrame> frames = pipeline.PlayAll();
  ASSERT_EQ(frames.size(), 4u);
  for (size_t n = 0; n < 4; ++n)
    EXPECT_EQ(frames[n].bytes, Draw({64, 64, n < 2 ? 10.0f : 45.0f})) << n;
}

TEST(CosplatSrc, TimesGoOnWhereCapsChange) {
  Pipeline pipeline(Source() + " ! capsfilter name=caps caps=video/x-raw,width=64,height=48," +
                    "framerate=25/1");
  ASSERT_TRUE(pipeline.Set(GST_STATE_PLAYING));
  PulledFrame frame;
  GstClockTime end = 0;
  for (int n = 0; n < 10; ++n) {
    ASSERT_TRUE(pipeline.Pull(frame));
    EXPECT_EQ(frame.pts, end);
    end = frame.pts + frame.duration;
    if (n != 2) continue;
    GstCaps* caps = gst_caps_from_string("video/x-raw,width=32,height=96,framerate=30000/1001");
    g_object_set(pipeline.Named("caps"), "caps", caps, nullptr);
    gst_caps_unref(caps);
  }
  EXPECT_EQ(frame.bytes, Draw({32, 96}));
  EXPECT_NEAR(double(frame.duration), 1001e9 / 30000, 1);
}

TEST(CosplatSrc, LiveFramesLieOnTheClocksLattice) {
  Pipeline pipeline(Source("width=32 height=32 fps=50 is-live=true num-buffers=10"));
  ASSERT_TRUE(pipeline.Set(GST_STATE_PLAYING));
  GstQuery* query = gst_query_new_latency();
  ASSERT_TRUE(gst_element_query(pipeline.Named("src"), query));
  gboolean live = FALSE;
  GstClockTime min = 0, max = 0;
  gst_query_parse_latency(query, &live, &min, &max);
  gst_query_unref(query);
  EXPECT_TRUE(live);
  EXPECT_EQ(min, GST_SECOND / 50);
  EXPECT_EQ(max, GST_CLOCK_TIME_NONE);
  GstClockTime last = 0;
  int count = 0;
  for (PulledFrame frame; pipeline.Pull(frame); ++count) {
    EXPECT_EQ(frame.pts % (GST_SECOND / 50), 0u);
    if (count > 0) {
      EXPECT_GT(frame.pts, last);
    }
    last = frame.pts;
    // Not before its time.
    GstClock* clock = gst_element_get_clock(pipeline.element());
    EXPECT_GE(gst_clock_get_time(clock), gst_element_get_base_time(pipeline.element()) + last);
    gst_object_unref(clock);
  }
  EXPECT_EQ(count, 10);
}

// A pause of any length leaves no gap; what is not live shows every frame.
TEST(CosplatSrc, GoesOnAfterAPause) {
  Pipeline pipeline(Source("width=32 height=32 fps=50 num-buffers=12"));
  PulledFrame frame;
  for (GstClockTime n = 0; n < 12; ++n) {
    if (n % 4 == 0) {
      ASSERT_TRUE(pipeline.Set(GST_STATE_PAUSED));
      g_usleep(50'000);
      ASSERT_TRUE(pipeline.Set(GST_STATE_PLAYING));
    }
    ASSERT_TRUE(pipeline.Pull(frame));
    EXPECT_EQ(frame.pts, n * GST_SECOND / 50);
  }
  EXPECT_FALSE(pipeline.Pull(frame));
}

// A face has no place to seek to: it says so, and a seek that is tried does no harm.
TEST(CosplatSrc, RefusesToSeek) {
  Pipeline pipeline(Source("width=32 height=32 fps=50"));
  ASSERT_TRUE(pipeline.Set(GST_STATE_PLAYING));
  PulledFrame frame;
  ASSERT_TRUE(pipeline.Pull(frame));
  GstQuery* query = gst_query_new_seeking(GST_FORMAT_TIME);
  if (gst_element_query(pipeline.Named("src"), query)) {
    gboolean seekable = TRUE;
    gst_query_parse_seeking(query, nullptr, &seekable, nullptr, nullptr);
    EXPECT_FALSE(seekable);
  }
  gst_query_unref(query);
  for (const GstSeekFlags flags : {GST_SEEK_FLAG_NONE, GST_SEEK_FLAG_FLUSH})
    EXPECT_FALSE(
        gst_element_seek_simple(pipeline.element(), GST_FORMAT_TIME, flags, GST_SECOND / 10));
  const GstClockTime before = frame.pts;
  for (int n = 0; n < 5; ++n) ASSERT_TRUE(pipeline.Pull(frame));
  EXPECT_EQ(frame.pts, before + 5 * GST_SECOND / 50);
  EXPECT_EQ(pipeline.Error(0), "");
}

// Two in one process, at once, each with its own face and view.
TEST(CosplatSrc, TwoAtOnce) {
  Pipeline front(Source("width=48 height=48")), side(Source("width=48 height=48 azimuth=45"));
  const std::vector<uint8_t> expected[2] = {Draw({48, 48}), Draw({48, 48, 45})};
  ASSERT_NE(expected[0], expected[1]);
  ASSERT_TRUE(front.Set(GST_STATE_PLAYING) && side.Set(GST_STATE_PLAYING));
  PulledFrame frame;
  for (int n = 0; n < 20; ++n) {
    ASSERT_TRUE(front.Pull(frame));
    EXPECT_EQ(frame.bytes, expected[0]);
    ASSERT_TRUE(side.Pull(frame));
    EXPECT_EQ(frame.bytes, expected[1]);
  }
}

// A frame that is due in minutes does not hold up the end.
TEST(CosplatSrc, StopsWhileItWaits) {
  Pipeline pipeline(Source("width=32 height=32 fps=1/500 is-live=true"));
  for (const GstState last : {GST_STATE_PAUSED, GST_STATE_NULL}) {
    gst_element_set_state(pipeline.element(), GST_STATE_PLAYING);
    g_usleep(20000);
    ASSERT_TRUE(pipeline.Set(last));
  }
}

}  // namespace
}  // namespace cosplat::test
