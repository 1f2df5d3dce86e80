// Pipelines around cosplatsrc, run in the test's own process, and what must come out of them.
#pragma once

#include <gst/app/gstappsink.h>
#include <gst/video/video.h>

#include "tests/hosts/expected_picture.h"

namespace cosplat::test {

// One picture that left a pipeline.
struct PulledFrame {
  int width = 0, height = 0;
  GstVideoFormat format = GST_VIDEO_FORMAT_UNKNOWN;
  GstClockTime pts = 0, duration = 0;
  std::vector<uint8_t> bytes;  // rows without gaps
};

// "avatar=... flame=..." of the test's avatar.
inline std::string AvatarProperties() {
  const PluginFiles& files = PluginFiles::Get();
  return "avatar=" + files.avatar_path + " flame=" + files.flame_path;
}

// A pipeline that ends in an appsink.
class Pipeline {
 public:
  // `line` comes before the appsink, as one types it for gst-launch-1.0.
  explicit Pipeline(const std::string& line) {
    gst_init(nullptr, nullptr);
    GError* error = nullptr;
    pipeline_ = gst_parse_launch((line + " ! appsink name=sink sync=false").c_str(), &error);
    EXPECT_EQ(error, nullptr) << error->message;
    sink_ = GST_APP_SINK(gst_bin_get_by_name(GST_BIN(pipeline_), "sink"));
    // Ahead of the test by no more than a frame.
    gst_app_sink_set_max_buffers(sink_, 1);
  }
  ~Pipeline() {
    Set(GST_STATE_NULL);
    gst_object_unref(sink_);
    gst_object_unref(pipeline_);
  }
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  GstElement* element() const { return pipeline_; }
  GstElement* Named(const char* name) const {
    GstElement* found = gst_bin_get_by_name(GST_BIN(pipeline_), name);
    gst_object_unref(found);  // the pipeline holds it
    return found;
  }

  // Waits until it is there.
  bool Set(GstState state) {
    gst_element_set_state(pipeline_, state);
    return gst_element_get_state(pipeline_, nullptr, nullptr, GST_CLOCK_TIME_NONE) !=
           GST_STATE_CHANGE_FAILURE;
  }

  // False at the end of the stream.
  bool Pull(PulledFrame& out) {
    GstSample* sample = gst_app_sink_pull_sample(sink_);
    if (!sample) return false;
    GstVideoInfo info;
    EXPECT_TRUE(gst_video_info_from_caps(&info, gst_sample_get_caps(sample)));
    GstBuffer* buffer = gst_sample_get_buffer(sample);
    GstVideoFrame frame;
    EXPECT_TRUE(gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ));
    out = {info.width,
           info.height,
           GST_VIDEO_INFO_FORMAT(&info),
           GST_BUFFER_PTS(buffer),
           GST_BUFFER_DURATION(buffer),
           {}};
    const auto* row = static_cast<const uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
    for (int y = 0; y < info.height; ++y, row += GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0))
      out.bytes.insert(out.bytes.end(), row, row + 4 * info.width);
    gst_video_frame_unmap(&frame);
    gst_sample_unref(sample);
    return true;
  }

  // Plays from the beginning to the end of the stream.
  std::vector<PulledFrame> PlayAll() {
    EXPECT_TRUE(Set(GST_STATE_PLAYING));
    std::vector<PulledFrame> frames;
    for (PulledFrame frame; Pull(frame);) frames.push_back(frame);
    return frames;
  }

  // The first error that the pipeline posts within this time; "" if there is none.
  std::string Error(GstClockTime within) {
    return Told(GST_MESSAGE_ERROR, gst_message_parse_error, within);
  }
  std::string Warning(GstClockTime within) {
    return Told(GST_MESSAGE_WARNING, gst_message_parse_warning, within);
  }

 private:
  std::string Told(GstMessageType type,
                   void (*parse)(GstMessage*, GError**, char**),
                   GstClockTime within) {
    GstBus* bus = gst_element_get_bus(pipeline_);
    std::string text;
    if (GstMessage* message = gst_bus_timed_pop_filtered(bus, within, type)) {
      GError* error = nullptr;
      parse(message, &error, nullptr);
      text = error->message;
      g_error_free(error);
      gst_message_unref(message);
    }
    gst_object_unref(bus);
    return text;
  }

  GstElement* pipeline_;
  GstAppSink* sink_;
};

}  // namespace cosplat::test
