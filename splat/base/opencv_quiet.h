// Keeps OpenCV and FFmpeg from writing to stderr: failures are reported as Error instead.
#pragma once

#include <cstdlib>
#include <opencv2/core/utils/logger.hpp>

namespace cosplat {

inline void QuietOpenCv() {
  static const bool once = [] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // AV_LOG_QUIET; read when a video is opened
    return true;
  }();
  (void)once;
}

}  // namespace cosplat
