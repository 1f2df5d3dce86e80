#include "splat/media/image_io.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/media/opencv_mat.h"

namespace cosplat {
namespace {

// Keeps OpenCV from writing to stderr, since failures are reported as Error. Only the first call
// has an effect.
void QuietOpenCv() {
  static const bool once = [] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    return true;
  }();
  (void)once;
}

std::string ExtensionOf(const std::string& path) {
  const size_t dot = path.rfind('.');
  return dot == std::string::npos ? "" : LowerCase(path.substr(dot));
}

// RGB <-> BGR, keeping alpha. Never in place, since `image` may wrap a caller's pixels.
cv::Mat SwapRedBlue(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat swapped;
  if (image.channels() == 3) cv::cvtColor(image, swapped, cv::COLOR_BGR2RGB);
  if (image.channels() == 4) cv::cvtColor(image, swapped, cv::COLOR_BGRA2RGBA);
  return swapped;
}

Image8 ToImage8(const cv::Mat& mat) {
  Image8 image(mat.cols, mat.rows, mat.channels());
  mat.copyTo(MatOf(image));
  return image;
}

// Colour times alpha, as floats in [0, 255], so that averages weight colour by coverage.
cv::Mat Premultiplied(const Image8& image) {
  cv::Mat result;
  MatOf(image).convertTo(result, CV_32F);
  if (image.channels != 4) return result;
  for (int y = 0; y < result.rows; ++y) {
    cv::Vec4f* row = result.ptr<cv::Vec4f>(y);
    for (int x = 0; x < result.cols; ++x)
      for (int c = 0; c < 3; ++c) row[x][c] *= row[x][3] / 255;
  }
  return result;
}

Image8 Unpremultiplied(cv::Mat mat) {
  if (mat.channels() == 4) {
    for (int y = 0; y < mat.rows; ++y) {
      cv::Vec4f* row = mat.ptr<cv::Vec4f>(y);
      for (int x = 0; x < mat.cols; ++x)
        for (int c = 0; c < 3; ++c)
          row[x][c] = row[x][3] > 0 ? std::min(row[x][c] * 255 / row[x][3], 255.f) : 0;
    }
  }
  cv::Mat bytes;
  mat.convertTo(bytes, CV_8U);
  return ToImage8(bytes);
}

// Whether a decoded RGBA image has its colours multiplied by alpha: a TIFF whose file says so, or
// one of 8 bits that says it has not, which libtiff multiplies.
bool IsPremultiplied(const ExifInfo& exif, int depth) {
  return exif.extra_samples == 1 || (exif.extra_samples == 2 && depth == CV_8U);
}

cv::Mat Divided(const cv::Mat& bgra) {
  cv::Mat floats;
  bgra.convertTo(floats, CV_32F);
  return MatOf(Unpremultiplied(floats)).clone();
}

cv::Mat DecodeAny(const std::string& path, const std::vector<char>& bytes) {
  try {
    const cv::Mat raw(1, int(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    return cv::imdecode(raw, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    throw Error(path, "cannot be decoded as an image: " + error.err);
  }
}

// A JPEG without an end marker. What follows the last block is not decoded, and what follows a cut
// is: then the pixels depend on it. The last rows of blocks come out only if something follows.
cv::Mat DecodeWithoutEnd(const std::string& path, const std::vector<char>& bytes) {
  constexpr size_t kMore = 1 << 20;  // more than the widest row of blocks
  cv::Mat decoded[2];
  for (int i = 0; i < 2; ++i) {
    std::vector<char> longer = bytes;
    longer.insert(longer.end(), kMore, i == 0 ? 0x00 : 0x5a);
    decoded[i] = DecodeAny(path, longer);
  }
  if (decoded[0].size() != decoded[1].size() || decoded[0].type() != decoded[1].type() ||
      (!decoded[0].empty() && cv::norm(decoded[0], decoded[1], cv::NORM_INF) > 0))
    throw Error(path, "is truncated after " + std::to_string(bytes.size()) + " bytes");
  return decoded[0];
}

// A TIFF as it is stored: OpenCV turns it by its orientation, whatever it is asked.
cv::Mat DecodeUnturned(const std::string& path, std::vector<char> bytes, size_t orientation_at) {
  const bool little = bytes[0] == 'I';
  bytes[orientation_at] = little ? 1 : 0;
  bytes[orientation_at + 1] = little ? 0 : 1;
  return DecodeAny(path, bytes);
}

// Labels of 16 bits (one channel, none above 255) are no brightness: they stay as they are.
cv::Mat To8Bits(const cv::Mat& mat) {
  double highest = 256;
  if (mat.channels() == 1) cv::minMaxLoc(mat, nullptr, &highest);
  cv::Mat bytes;
  mat.convertTo(bytes, CV_8U, highest <= 255 ? 1 : 1.0 / 257);
  return bytes;
}

cv::Mat Decode(const std::string& path, const std::vector<char>& bytes) {
  QuietOpenCv();
  CheckImageIsComplete(path, bytes);
  const ExifInfo exif = ParseExif(bytes);
  if (exif.is_raw) throw Error(path, kRawImage);
  cv::Mat mat = LacksJpegEnd(bytes)       ? DecodeWithoutEnd(path, bytes)
                : exif.orientation_at > 0 ? DecodeUnturned(path, bytes, exif.orientation_at)
                                          : DecodeAny(path, bytes);
  if (mat.empty()) {
    const std::string other = OtherContent({bytes.data(), std::min<size_t>(bytes.size(), 64)});
    throw Error(path, other.empty() ? "cannot be decoded as an image" : other);
  }
  const bool multiplied = mat.channels() == 4 && IsPremultiplied(exif, mat.depth());
  if (mat.depth() == CV_16U) mat = To8Bits(mat);
  if (multiplied) mat = Divided(mat);
  const int n = mat.channels();
  if (mat.depth() != CV_8U || (n != 1 && n != 3 && n != 4))
    throw Error(
        path, "", "has pixels of an unknown type, expected 8 or 16 bits, 1, 3 or 4 channels");
  return mat;
}

// OpenCV puts pixel centres at integers, this project at +0.5.
cv::Matx33d OpenCvMatrix(const Camera& camera) {
  return {camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1};
}

// The rays' points (normalised) under the division model, px with the first pixel's centre at 0.
// Not finite where the lens shows no such ray. Of the two points that have a ray, the one that
// tends to it as k does to 0; written without its cancellation.
std::vector<cv::Point2d> Divided(const std::vector<cv::Point2d>& rays,
                                 const Camera& source,
                                 double k) {
  std::vector<cv::Point2d> points;
  points.reserve(rays.size());
  for (const cv::Point2d& ray : rays) {
    const double scale = 2 / (1 + std::sqrt(1 - 4 * k * ray.dot(ray)));
    points.emplace_back(source.fx * scale * ray.x + source.cx - 0.5,
                        source.fy * scale * ray.y + source.cy - 0.5);
  }
  return points;
}

}  // namespace

ImageInfo ReadImageInfo(const std::string& path) {
  // Metadata (EXIF, colour profiles) may precede the size: read more until the header is complete.
  constexpr size_t kFirst = 1 << 16, kLast = 1 << 22;
  for (size_t size = kFirst; size <= kLast; size *= 8) {
    std::ifstream stream(path, std::ios::binary);
    std::vector<char> bytes(size);
    stream.read(bytes.data(), std::streamsize(size));
    bytes.resize(size_t(std::max<std::streamsize>(stream.gcount(), 0)));
    ImageInfo info;
    const bool complete = ParseImageHeader(bytes, info);
    info.orientation = ParseExif(bytes).orientation;
    if (complete) return info;
    if (bytes.size() < size) break;
  }
  const std::vector<char> bytes = ReadFile(path);
  const Image8 image = ToImage8(SwapRedBlue(Decode(path, bytes)));
  return {image.width, image.height, image.channels, ParseExif(bytes).orientation};
}

Image8 ReadImage(const std::string& path) {
  return ToImage8(SwapRedBlue(Decode(path, ReadFile(path))));
}

Image8 ReadUpright(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return Upright(ToImage8(SwapRedBlue(Decode(path, bytes))), ParseExif(bytes).orientation);
}

std::vector<uint8_t> EncodeImage(const std::string& path, const Image8& image) {
  QuietOpenCv();
  const std::string extension = ExtensionOf(path);
  const bool jpeg = extension == ".jpg" || extension == ".jpeg";
  if (!jpeg && extension != ".png")
    throw Error(path, "unknown image extension '" + extension + "', expected .png or .jpg");
  if (image.empty() || (image.channels != 1 && image.channels != 3 && image.channels != 4) ||
      (jpeg && image.channels == 4))
    throw Error(path,
                "cannot store an image of " + SizeText(image.width, image.height) + " with " +
                    std::to_string(image.channels) + " channels as " + extension);
  std::vector<uint8_t> bytes;
  if (!cv::imencode(extension, SwapRedBlue(MatOf(image)), bytes))
    throw Error(path, "image could not be encoded");
  return bytes;
}

Image8 ResizeByArea(const Image8& image, int width, int height) {
  if (width == image.width && height == image.height) return image;
  if (width < 1 || height < 1 || image.empty())
    throw Error("image",
                "cannot be resized from " + SizeText(image.width, image.height) + " to " +
                    SizeText(width, height));
  cv::Mat resized;
  cv::resize(Premultiplied(image), resized, cv::Size(width, height), 0, 0, cv::INTER_AREA);
  return Unpremultiplied(resized);
}

Image8 Undistort(const Image8& image,
                 const Camera& source,
                 const Distortion& distortion,
                 const Camera& target) {
  const cv::Matx33d source_matrix = OpenCvMatrix(source), target_matrix = OpenCvMatrix(target);
  const cv::Size size(target.width, target.height);
  cv::Mat map_x, map_y;
  if (distortion.model == Distortion::Model::kFisheye) {
    const cv::Vec4d k(distortion.k);
    cv::fisheye::initUndistortRectifyMap(
        source_matrix, k, cv::Matx33d::eye(), target_matrix, size, CV_32FC1, map_x, map_y);
  } else if (distortion.model == Distortion::Model::kDivision) {
    map_x.create(size, CV_32FC1);
    map_y.create(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y) {
      std::vector<cv::Point2d> rays;
      for (int x = 0; x < size.width; ++x)
        rays.emplace_back((x + 0.5 - target.cx) / target.fx, (y + 0.5 - target.cy) / target.fy);
      const std::vector<cv::Point2d> points = Divided(rays, source, distortion.k[0]);
      for (int x = 0; x < size.width; ++x) {
        map_x.at<float>(y, x) = float(points[x].x);
        map_y.at<float>(y, x) = float(points[x].y);
      }
    }
  } else {
    const cv::Vec<double, 8> k(distortion.k);
    cv::initUndistortRectifyMap(
        source_matrix, k, cv::noArray(), target_matrix, size, CV_32FC1, map_x, map_y);
  }
  cv::Mat result;
  cv::remap(Premultiplied(image), result, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return Unpremultiplied(result);
}

std::vector<std::array<double, 2>> DistortedPixels(
    const Camera& source,
    const Distortion& distortion,
    const Camera& target,
    const std::vector<std::array<double, 2>>& points) {
  std::vector<cv::Point2d> rays, out;
  for (const auto& p : points)
    rays.emplace_back((p[0] - target.cx) / target.fx, (p[1] - target.cy) / target.fy);
  if (distortion.model == Distortion::Model::kFisheye) {
    cv::fisheye::distortPoints(rays, out, OpenCvMatrix(source), cv::Vec4d(distortion.k));
  } else if (distortion.model == Distortion::Model::kDivision) {
    out = Divided(rays, source, distortion.k[0]);
  } else {
    std::vector<cv::Point3d> far;
    for (const cv::Point2d& ray : rays) far.emplace_back(ray.x, ray.y, 1);
    const cv::Vec<double, 8> k(distortion.k);
    cv::projectPoints(far, cv::Vec3d(), cv::Vec3d(), OpenCvMatrix(source), k, out);
  }
  std::vector<std::array<double, 2>> result;
  for (const cv::Point2d& p : out) result.push_back({p.x + 0.5, p.y + 0.5});
  return result;
}

}  // namespace cosplat
