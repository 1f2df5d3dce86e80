#include <algorithm>
#include <cmath>

#include "apps/cosplat/run/frame_source.h"

namespace cosplat {
namespace {

constexpr int kMinBar = 4;                            // px
constexpr double kMinShare = 0.02, kMaxShare = 0.45;  // width of a bar, of the frame's
constexpr int kMaxUneven = 2;                         // px, between the two
// An edge: this share of its pixels differs by so much from one side to the other.
constexpr double kMinEdge = 0.5;
constexpr int kMinStep = 6;  // of 255
// Detail of bars beside the picture's, and of a picture in which one can see anything: mean second
// differences.
constexpr double kMaxDetail = 0.35, kMinDetail = 0.1;

struct Grey {
  int width, height;
  std::vector<int> values;

  int at(int x, int y) const { return values[size_t(y) * size_t(width) + size_t(x)]; }
};

Grey GreyOf(const Image8& image, bool transposed) {
  Grey grey{transposed ? image.height : image.width, transposed ? image.width : image.height, {}};
  grey.values.reserve(image.pixels());
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x) {
      const uint8_t* rgb = transposed ? &image.at(y, x, 0) : &image.at(x, y, 0);
      grey.values.push_back((rgb[0] + 2 * rgb[1] + rgb[2]) / 4);
    }
  return grey;
}

// Of each column: the share of an edge's pixels, and the mean second difference across it.
struct Columns {
  std::vector<double> edge, detail;

  double MeanDetail(int begin, int end) const {
    double sum = 0;
    for (int x = begin; x < end; ++x) sum += detail[size_t(x)];
    return sum / std::max(1, end - begin);
  }
};

Columns ColumnsOf(const Grey& image) {
  Columns columns{std::vector<double>(size_t(image.width)),
                  std::vector<double>(size_t(image.width))};
  for (int y = 0; y < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const int left = image.at(x - 1, y), right = image.at(x + 1, y);
      if (std::abs(right - left) > kMinStep) columns.edge[size_t(x)] += 1.0 / image.height;
      columns.detail[size_t(x)] +=
          double(std::abs(2 * image.at(x, y) - left - right)) / image.height;
    }
  return columns;
}

// Medians over the frames, of which one may be a title.
Columns ColumnsOf(const std::vector<Image8>& frames, bool transposed) {
  std::vector<Columns> all;
  for (const Image8& frame : frames) all.push_back(ColumnsOf(GreyOf(frame, transposed)));
  Columns columns = all[0];
  for (std::vector<double> Columns::*const of : {&Columns::edge, &Columns::detail})
    for (size_t x = 0; x < columns.edge.size(); ++x) {
      std::vector<double> values;
      for (const Columns& each : all) values.push_back((each.*of)[x]);
      std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
      (columns.*of)[x] = values[values.size() / 2];
    }
  return columns;
}

struct Between {
  int begin, end;  // columns of the picture
};

std::optional<Between> BetweenBars(const Columns& columns) {
  const int width = int(columns.edge.size());
  double best = kMinEdge;
  int left = 0, right = 0;
  for (int x = std::max(kMinBar, int(kMinShare * width)); x < int(kMaxShare * width); ++x)
    for (int k = -kMaxUneven; k <= kMaxUneven; ++k) {
      const int other = width - 1 - x + k;
      const double edge = std::min(columns.edge[size_t(x)], columns.edge[size_t(other)]);
      if (edge > best) best = edge, left = x, right = other;
    }
  if (left == 0) return {};
  const double outside =
      (columns.MeanDetail(0, left - 1) + columns.MeanDetail(right + 2, width)) / 2;
  // The edges themselves, which a codec smears, are in neither.
  const Between picture{left + 2, right - 1};
  if (outside > kMaxDetail * columns.MeanDetail(picture.begin, picture.end)) return {};
  return picture;
}

}  // namespace

std::optional<Crop> PictureBetweenBars(const std::vector<Image8>& frames) {
  const Columns columns = ColumnsOf(frames, false), rows = ColumnsOf(frames, true);
  Crop picture{0, 0, int(columns.edge.size()), int(rows.edge.size())};
  if (columns.MeanDetail(0, picture.width) < kMinDetail) return {};
  if (const auto across = BetweenBars(columns))
    picture.x = across->begin, picture.width = across->end - across->begin;
  else if (const auto down = BetweenBars(rows))
    picture.y = down->begin, picture.height = down->end - down->begin;
  return picture;
}

}  // namespace cosplat
