#include "flame/fit/frame_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "splat/media/image_io.h"
#include "splat/media/signed_distance.h"

namespace cosplat::internal {
namespace {

// Radii of three box filters in a row, which come close to a Gaussian of the same width.
constexpr int kFineRadius = 1, kCoarseRadius = 8;
// Blurred brightness is divided by the blurred matte, but by no less.
constexpr float kMinMatte = 0.05f;
// A matte's value from which on a pixel is the person's.
constexpr uint8_t kInside = 128;
// A distance varies slowly: its pixels per pixel of brightness.
constexpr double kRimScale = 0.5;
constexpr size_t kFramesAtOnce = 16;

// One box filter along the rows; the result is transposed.
Image BoxFilter(const Image& in, int radius) {
  Image out(in.height, in.width, 1);
  for (int y = 0; y < in.height; ++y) {
    const auto at = [&](int x) { return double(in.at(std::clamp(x, 0, in.width - 1), y, 0)); };
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) sum += at(x);
    for (int x = 0; x < in.width; ++x) {
      out.at(y, x, 0) = float(sum / (2 * radius + 1));
      sum += at(x + radius + 1) - at(x - radius);
    }
  }
  return out;
}

Image Blur(Image image, int radius) {
  for (int pass = 0; pass < 3; ++pass) image = BoxFilter(BoxFilter(image, radius), radius);
  return image;
}

// The frame's part, resized.
struct Part {
  FrameField field;  // without its image
  Image8 image;
};

Part PartOf(const Image8& frame, const std::array<double, 4>& box, double scale) {
  const int left = int(std::clamp(box[0], 0.0, frame.width - 2.0));
  const int top = int(std::clamp(box[1], 0.0, frame.height - 2.0));
  const int right = int(std::clamp(std::ceil(box[2]), left + 2.0, double(frame.width)));
  const int bottom = int(std::clamp(std::ceil(box[3]), top + 2.0, double(frame.height)));
  Part part;
  part.image = Cropped(frame, {left, top, right - left, bottom - top});
  if (scale < 1)
    part.image = ResizeByArea(part.image,
                              std::max(2, int(std::lround(part.image.width * scale))),
                              std::max(2, int(std::lround(part.image.height * scale))));
  part.field.scale = double(part.image.width) / (right - left);
  part.field.corner = {double(left), double(top)};
  return part;
}

}  // namespace

std::array<double, 3> InView(const FrameView& view, const std::array<double, 3>& point) {
  std::array<double, 3> out = view.translation;
  for (size_t r = 0; r < 3; ++r)
    for (size_t k = 0; k < 3; ++k) out[r] += view.rotation[3 * r + k] * point[k];
  return out;
}

std::array<double, 3> InViewVjp(const FrameView& view, const std::array<double, 3>& d_out) {
  std::array<double, 3> d_point{};
  for (size_t r = 0; r < 3; ++r)
    for (size_t k = 0; k < 3; ++k) d_point[k] += view.rotation[3 * r + k] * d_out[r];
  return d_point;
}

FrameField BandPass(const Image8& frame, const std::array<double, 4>& box, double scale) {
  auto [out, part] = PartOf(frame, box, scale);
  Image matte(part.width, part.height, 1, 1.0f), grey = matte;
  for (size_t i = 0; i < part.pixels(); ++i) {
    const uint8_t* const p = &part.data[i * size_t(part.channels)];
    if (part.channels == 4) matte.data[i] = float(p[3]) / 255;
    // Luma of Rec. 601
    grey.data[i] = matte.data[i] * (0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2]);
  }
  const Image fine = Blur(grey, kFineRadius), fine_matte = Blur(matte, kFineRadius);
  const Image coarse = Blur(grey, kCoarseRadius), coarse_matte = Blur(matte, kCoarseRadius);
  out.image = std::move(grey);
  for (size_t i = 0; i < part.pixels(); ++i)
    out.image.data[i] = fine.data[i] / std::max(fine_matte.data[i], kMinMatte) -
                        coarse.data[i] / std::max(coarse_matte.data[i], kMinMatte);
  return std::move(out);
}

std::optional<FrameField> RimDistance(const Image8& frame,
                                      const std::array<double, 4>& box,
                                      double scale) {
  auto [out, part] = PartOf(frame, box, scale);
  const Image8 matte = ChannelOf(part, 3);
  const auto [min, max] = std::minmax_element(matte.data.begin(), matte.data.end());
  if (*min >= kInside || *max < kInside) return std::nullopt;
  out.image = SignedDistance(matte, kInside);
  for (float& d : out.image.data) d /= float(out.scale);
  return out;
}

FieldAt SampleAt(const FrameField& field, double x, double y) {
  // Pixels' centres are at halves.
  const double u = (x - field.corner[0]) * field.scale - 0.5;
  const double v = (y - field.corner[1]) * field.scale - 0.5;
  const int width = field.image.width, height = field.image.height;
  if (!(u >= 0 && v >= 0 && u < width - 1 && v < height - 1)) return {};
  const int i = int(u), j = int(v);
  const double a = u - i, b = v - j;
  const float* const p = &field.image.at(i, j, 0);
  const double top = (1 - a) * p[0] + a * p[1], bottom = (1 - a) * p[width] + a * p[width + 1];
  FieldAt out;
  out.inside = true;
  out.value = (1 - b) * top + b * bottom;
  out.d_x = field.scale * ((1 - b) * (double(p[1]) - p[0]) + b * (double(p[width + 1]) - p[width]));
  out.d_y = field.scale * (bottom - top);
  return out;
}

std::vector<FrameFields> ReadFields(const std::vector<std::optional<FrameView>>& views,
                                    const std::function<Image8(size_t f)>& image) {
  double size = 0, count = 0;
  for (const auto& view : views)
    if (view) size += view->face_size, ++count;
  const double scale = std::min(1.0, kBandPassFace * count / size);
  std::vector<FrameFields> fields(views.size());
  for (size_t begin = 0; begin < views.size(); begin += kFramesAtOnce) {
    const size_t end = std::min(begin + kFramesAtOnce, views.size());
    std::vector<Image8> read(kFramesAtOnce);  // videos are decoded in order
    for (size_t f = begin; f < end; ++f)
      if (views[f]) read[f - begin] = image(f);
    tbb::parallel_for(begin, end, [&](size_t f) {
      if (!views[f]) return;
      const FrameView& view = *views[f];
      const Image8& frame = read[f - begin];
      fields[f].brightness = BandPass(frame, view.box, scale);
      if (frame.channels == 4) fields[f].rim = RimDistance(frame, view.box, kRimScale * scale);
    });
  }
  return fields;
}

}  // namespace cosplat::internal
