// What of image_filters.h is OpenCV's.
#include <opencv2/imgproc.hpp>

#include "splat/media/image_filters.h"

namespace cosplat {
namespace {

template <class T>
cv::Mat MatOf(const BasicImage<T>& image) {
  const int depth = std::is_same_v<T, float> ? CV_32F : CV_8U;
  return cv::Mat(image.height,
                 image.width,
                 CV_MAKETYPE(depth, image.channels),
                 const_cast<T*>(image.data.data()));
}

}  // namespace

Image BoxMean(const Image& image, int radius) {
  Image result(image.width, image.height, image.channels);
  cv::Mat out = MatOf(result);
  const int size = 2 * radius + 1;
  cv::boxFilter(MatOf(image), out, CV_32F, {size, size}, {-1, -1}, true, cv::BORDER_REFLECT);
  return result;
}

ConnectedParts PartsOf(const Image8& mask) {
  cv::Mat labels;
  ConnectedParts parts;
  parts.count = cv::connectedComponents(MatOf(mask), labels, 4, CV_32S) - 1;
  parts.labels.assign(labels.begin<int>(), labels.end<int>());
  return parts;
}

}  // namespace cosplat
