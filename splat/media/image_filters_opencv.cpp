// What of image_filters.h is OpenCV's.
#include <opencv2/imgproc.hpp>

#include "splat/media/image_filters.h"
#include "splat/media/opencv_mat.h"

namespace cosplat {

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
