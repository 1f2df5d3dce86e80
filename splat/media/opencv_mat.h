// Images as OpenCV's matrices, without a copy. Private to splat/media/.
#pragma once

#include <opencv2/core.hpp>
#include <type_traits>

#include "splat/base/image.h"

namespace cosplat {

template <class T>
cv::Mat MatOf(const BasicImage<T>& image) {
  const int depth = std::is_same_v<T, float> ? CV_32F : CV_8U;
  return cv::Mat(image.height,
                 image.width,
                 CV_MAKETYPE(depth, image.channels),
                 const_cast<T*>(image.data.data()));
}

}  // namespace cosplat
