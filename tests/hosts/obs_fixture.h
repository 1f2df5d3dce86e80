// OBS itself, without its window: a canvas on an X server without a screen, and what is seen on it.
#pragma once

#include <obs-nix-platform.h>
#include <obs.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

#include "tests/hosts/expected_picture.h"
#include "tests/viewer/virtual_display.h"

// Of Xlib, whose header makes macros of words that gtest uses.
extern "C" struct _XDisplay* XOpenDisplay(const char* name);
extern "C" int XCloseDisplay(struct _XDisplay* display);

namespace cosplat::test {

constexpr uint32_t kCanvas = 192;  // px either way

// What obs.h counts references of.
using SourcePointer = std::unique_ptr<obs_source_t, decltype(&obs_source_release)>;
using DataPointer = std::unique_ptr<obs_data_t, decltype(&obs_data_release)>;
using ScenePointer = std::unique_ptr<obs_scene_t, decltype(&obs_scene_release)>;

// The warnings that OBS and its modules wrote into their log.
struct ObsLog {
  std::mutex mutex;
  std::vector<std::string> lines;
};
inline ObsLog& WrittenLog() {
  static ObsLog log;
  return log;
}
inline void WriteLog(int level, const char* format, va_list arguments, void*) {
  if (level > LOG_WARNING) return;
  char line[1024];
  vsnprintf(line, sizeof(line), format, arguments);
  const std::lock_guard lock(WrittenLog().mutex);
  WrittenLog().lines.push_back(line);
}
inline bool WasLogged(const std::string& part) {
  const std::lock_guard lock(WrittenLog().mutex);
  const auto& lines = WrittenLog().lines;
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    return line.find(part) != std::string::npos;
  });
}

// A black source for the bottom of a scene: OBS divides a canvas that is not opaque by its alpha,
// in linear light, when it puts it out.
inline void RegisterBackdrop() {
  obs_source_info info{};
  info.id = "backdrop";
  info.type = OBS_SOURCE_TYPE_INPUT;
  info.output_flags = OBS_SOURCE_VIDEO | OBS_SOURCE_CUSTOM_DRAW;
  info.get_name = [](void*) { return "backdrop"; };
  info.create = [](obs_data_t*, obs_source_t* source) -> void* { return source; };
  info.destroy = [](void*) {};
  info.get_width = info.get_height = [](void*) { return kCanvas; };
  info.video_render = [](void*, gs_effect_t*) {
    gs_effect_t* solid = obs_get_base_effect(OBS_EFFECT_SOLID);
    const vec4 black = {{{0, 0, 0, 1}}};
    gs_effect_set_vec4(gs_effect_get_param_by_name(solid, "color"), &black);
    while (gs_effect_loop(solid, "Solid")) gs_draw_sprite(nullptr, 0, kCanvas, kCanvas);
  };
  obs_register_source(&info);
}

// One per process.
class Obs {
 public:
  Obs() {
    if (!screen_.there_is()) return;
    base_set_log_handler(WriteLog, nullptr);
    display_ = XOpenDisplay(nullptr);
    obs_set_nix_platform(OBS_NIX_PLATFORM_X11_EGL);
    obs_set_nix_platform_display(display_);
    EXPECT_TRUE(obs_startup("en-US", folder_.path().c_str(), nullptr));
    obs_video_info video{};
    video.graphics_module = "libobs-opengl";
    video.fps_num = 30;
    video.fps_den = 1;
    video.base_width = video.output_width = video.base_height = video.output_height = kCanvas;
    video.output_format = VIDEO_FORMAT_BGRA;
    video.gpu_conversion = true;
    EXPECT_EQ(obs_reset_video(&video), OBS_VIDEO_SUCCESS);
    obs_module_t* module = nullptr;
    EXPECT_EQ(obs_open_module(&module, COSPLAT_OBS_MODULE, COSPLAT_OBS_DATA), MODULE_SUCCESS);
    EXPECT_TRUE(obs_init_module(module));
    RegisterBackdrop();
    obs_add_raw_video_callback(nullptr, OnFrame, this);
  }
  // Ends OBS; what it still holds then is a leak.
  ~Obs() {
    if (!screen_.there_is()) return;
    obs_remove_raw_video_callback(OnFrame, this);
    obs_set_output_source(0, nullptr);
    while (obs_wait_for_destroy_queue()) {
    }
    obs_shutdown();
    XCloseDisplay(display_);
    EXPECT_EQ(bnum_allocs(), 0);
  }
  Obs(const Obs&) = delete;
  Obs& operator=(const Obs&) = delete;

  bool there_is() const { return screen_.there_is(); }

  // Waits until the canvas has the colours of `expected`, BGRA and as large, to within 1, since
  // graphics drivers may round either way. The largest difference, of the last canvas if it never
  // has.
  int WaitFor(const std::vector<uint8_t>& expected) {
    std::unique_lock lock(mutex_);
    int max = 256;
    arrived_.wait_for(lock, std::chrono::seconds(20), [&] {
      if (canvas_.size() != expected.size()) return false;
      max = 0;
      for (size_t i = 0; i < canvas_.size(); ++i)
        if (i % 4 != 3) max = std::max(max, std::abs(int(canvas_[i]) - int(expected[i])));
      return max <= 1;
    });
    return max;
  }

 private:
  static void OnFrame(void* data, video_data* frame) {
    Obs& obs = *static_cast<Obs*>(data);
    {
      const std::lock_guard lock(obs.mutex_);
      obs.canvas_.clear();
      for (uint32_t y = 0; y < kCanvas; ++y) {
        const uint8_t* row = frame->data[0] + size_t(y) * frame->linesize[0];
        obs.canvas_.insert(obs.canvas_.end(), row, row + size_t(4) * kCanvas);
      }
    }
    obs.arrived_.notify_all();
  }

  VirtualDisplay screen_;
  TemporaryFolder folder_;
  _XDisplay* display_ = nullptr;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<uint8_t> canvas_;
};

}  // namespace cosplat::test
