#include "flame/fit/choose_frames.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "flame/fit/landmark_scores.h"

namespace cosplat {
namespace {

constexpr double kTestShare = 0.2;   // as where a track says nothing of its test frames
constexpr double kMaxTestRate = 30;  // frames per second
constexpr size_t kLooksPerFrame = 2;
// Below this share of the median sharpness a face is blurred by its motion, or out of focus.
constexpr double kBlurred = 0.4;
// Distances of faces that count alike: of landmarks (root of the mean square, in units of the
// face's size) as when a head turns by some 20 degrees, and of scores (root of the sum).
constexpr double kPointsUnit = 0.1, kScoresUnit = 1;

// What a face looks like, apart from where it is: Euclidean distances compare.
std::vector<float> LookOf(const DetectedFace& face, LandmarkSet set) {
  std::array<double, 2> mean{0, 0};
  const double count = double(face.points.size());
  for (const auto& p : face.points)
    for (size_t k = 0; k < 2; ++k) mean[k] += p[k] / count;
  double spread = 0;
  for (const auto& p : face.points)
    spread += (std::pow(p[0] - mean[0], 2) + std::pow(p[1] - mean[1], 2)) / count;
  // Of points spread evenly over a square, whose side is the face's size.
  const double size = std::max(std::sqrt(6 * spread), 1e-6);
  std::vector<float> look;
  for (const auto& p : face.points)
    for (size_t k = 0; k < 2; ++k)
      look.push_back(float((p[k] - mean[k]) / (size * kPointsUnit * std::sqrt(count))));
  for (const auto& [name, score] : ScoresOf(face, set)) look.push_back(float(score / kScoresUnit));
  return look;
}

double Distance2(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * double(a[i] - b[i]);
  return sum;
}

const DetectedFace& Largest(const LandmarkFrame& frame) {
  const auto extent = [](const DetectedFace& face) {
    const auto [low, high] = std::minmax_element(
        face.points.begin(), face.points.end(), [](auto& a, auto& b) { return a[1] < b[1]; });
    return (*high)[1] - (*low)[1];
  };
  return *std::max_element(frame.faces.begin(),
                           frame.faces.end(),
                           [&](const auto& a, const auto& b) { return extent(a) < extent(b); });
}

// The first frames of a video that are not for testing, the usable ones first.
std::vector<size_t> Usable(const LandmarkVideo& seen, const std::vector<double>& sharpness) {
  std::vector<double> sharp;
  const size_t count = seen.frames.size() - size_t(seen.held_out);
  for (size_t i = 0; i < count; ++i)
    if (!seen.frames[i].faces.empty()) sharp.push_back(sharpness[i]);
  if (sharp.empty()) return {};
  std::nth_element(sharp.begin(), sharp.begin() + long(sharp.size() / 2), sharp.end());
  const double least = kBlurred * sharp[sharp.size() / 2];
  std::vector<size_t> usable;
  for (size_t i = 0; i < count; ++i)
    if (!seen.frames[i].faces.empty() && sharpness[i] >= least) usable.push_back(i);
  return usable;
}

// x and y of the first and the last corner, px.
std::array<double, 4> ExtentOf(const std::vector<std::array<double, 2>>& points) {
  std::array<double, 4> extent{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const auto& [x, y] : points)
    extent = {std::min(extent[0], x),
              std::min(extent[1], y),
              std::max(extent[2], x),
              std::max(extent[3], y)};
  return extent;
}

constexpr float kNoColor = -1;  // of a part that is not in the image

// Mean difference of the parts that both show; 0 if there is none.
double ColorChange(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  size_t count = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    if (a[k] == kNoColor || b[k] == kNoColor) continue;
    sum += std::abs(a[k] - b[k]);
    ++count;
  }
  return sum / double(std::max<size_t>(1, count));
}

}  // namespace

FrameSelection FramesToLookAt(size_t total, int wanted, double rate) {
  FrameSelection look;
  if (wanted == 0 || total <= size_t(wanted)) {
    for (size_t f = 0; f < total; ++f) look.frames.push_back(f);
    return look;
  }
  look.held_out = std::max(1, int(kTestShare * wanted));
  // Of a video that is little longer than the choice, most is left for training.
  const size_t step =
      std::min(size_t(std::max(1.0, std::round(rate / kMaxTestRate))), total / size_t(wanted));
  const size_t test = size_t(look.held_out) * step;
  const size_t training = size_t(wanted - look.held_out);
  const size_t left = total - test;
  const size_t gap = std::min(size_t(rate), left - std::min(left, training));
  const size_t rest = left - gap, count = std::min(rest, kLooksPerFrame * training);
  for (size_t i = 0; i < count; ++i) look.frames.push_back(i * rest / count);
  for (size_t i = 0; i < size_t(look.held_out); ++i) look.frames.push_back(left + i * step);
  return look;
}

double SharpnessOf(const Image8& image, const std::vector<std::array<double, 2>>& landmarks) {
  const auto [x0, y0, x1, y1] = ExtentOf(landmarks);
  const auto grey = [&](int x, int y) {
    return image.at(x, y, 0) + 2 * image.at(x, y, 1) + image.at(x, y, 2);
  };
  double sum = 0;
  size_t count = 0;
  for (int y = std::max(1, int(y0)); y < std::min(image.height - 1, int(y1)); ++y)
    for (int x = std::max(1, int(x0)); x < std::min(image.width - 1, int(x1)); ++x) {
      const double d =
          grey(x - 1, y) + grey(x + 1, y) + grey(x, y - 1) + grey(x, y + 1) - 4.0 * grey(x, y);
      sum += d * d;
      ++count;
    }
  return count > 0 ? sum / double(count) : 0;
}

std::vector<float> FaceColorsOf(const Image8& image,
                                const std::vector<std::array<double, 2>>& landmarks) {
  constexpr int kParts = 4;
  const auto [x0, y0, x1, y1] = ExtentOf(landmarks);
  std::vector<float> colors(3 * kParts * kParts);
  std::array<size_t, kParts * kParts> counts{};
  for (int y = std::max(0, int(y0)); y < std::min(image.height, int(y1)); ++y)
    for (int x = std::max(0, int(x0)); x < std::min(image.width, int(x1)); ++x) {
      const auto part_of = [](double at, double from, double to) {
        return std::clamp(int(kParts * (at - from) / (to - from)), 0, kParts - 1);
      };
      const size_t part = size_t(kParts * part_of(y + 0.5, y0, y1) + part_of(x + 0.5, x0, x1));
      for (int c = 0; c < 3; ++c) colors[3 * part + size_t(c)] += image.at(x, y, c);
      ++counts[part];
    }
  for (size_t i = 0; i < colors.size(); ++i)
    colors[i] = counts[i / 3] > 0 ? colors[i] / float(counts[i / 3]) : kNoColor;
  return colors;
}

std::vector<size_t> OtherLooks(const std::vector<std::vector<float>>& colors) {
  // Medians of some frames, since a hand or a flash passes.
  constexpr size_t kWindow = 5;
  constexpr double kMinChange = 12, kTimesUsual = 5;
  if (colors.size() < 2 * kWindow) return {};
  const auto median = [&](size_t begin) {
    std::vector<float> medians(colors[begin].size());
    for (size_t k = 0; k < medians.size(); ++k) {
      std::array<float, kWindow> values;
      for (size_t j = 0; j < kWindow; ++j) values[j] = colors[begin + j][k];
      std::nth_element(values.begin(), values.begin() + kWindow / 2, values.end());
      medians[k] = values[kWindow / 2];
    }
    return medians;
  };
  std::vector<double> change(colors.size());
  for (size_t i = kWindow; i + kWindow <= colors.size(); ++i)
    change[i] = ColorChange(median(i), median(i - kWindow));
  std::vector<double> sorted(change.begin() + kWindow, change.end() - kWindow + 1);
  std::nth_element(sorted.begin(), sorted.begin() + ptrdiff_t(sorted.size() / 2), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  // The largest step within the window is where it begins.
  const auto step = [&](size_t i) { return ColorChange(colors[i], colors[i - 1]); };
  std::vector<size_t> places;
  for (size_t i = kWindow; i + kWindow <= colors.size(); ++i) {
    if (change[i] <= std::max(kMinChange, kTimesUsual * usual)) continue;
    size_t at = i;
    for (; i + kWindow <= colors.size() && change[i] > kMinChange; ++i)
      if (step(i) > step(at)) at = i;
    places.push_back(at);
  }
  return places;
}

std::vector<size_t> ChooseFrames(const LandmarkVideo& seen,
                                 const std::vector<double>& sharpness,
                                 int wanted) {
  const std::vector<size_t> usable = Usable(seen, sharpness);
  const size_t training = seen.frames.size() - size_t(seen.held_out);
  const size_t count = std::min(training, size_t(wanted - seen.held_out));
  std::vector<bool> chosen(seen.frames.size(), false);
  for (size_t i = training; i < seen.frames.size(); ++i) chosen[i] = true;
  size_t done = 0;
  const size_t spread = std::min(count / 2, usable.size());
  for (; done < spread; ++done) chosen[usable[done * usable.size() / spread]] = true;
  // Farthest point sampling of the rest.
  std::vector<std::vector<float>> looks;
  for (const size_t i : usable) looks.push_back(LookOf(Largest(seen.frames[i]), seen.set));
  std::vector<double> nearest(usable.size(), HUGE_VAL);
  const auto take = [&](size_t k) {
    for (size_t j = 0; j < looks.size(); ++j)
      nearest[j] = std::min(nearest[j], Distance2(looks[k], looks[j]));
  };
  for (size_t k = 0; k < usable.size(); ++k)
    if (chosen[usable[k]]) take(k);
  for (; done < std::min(count, usable.size()); ++done) {
    size_t best = usable.size();
    for (size_t k = 0; k < usable.size(); ++k)
      if (!chosen[usable[k]] && (best == usable.size() || nearest[k] > nearest[best])) best = k;
    chosen[usable[best]] = true;
    take(best);
  }
  for (size_t i = 0; i < training && done < count; ++i)
    if (!chosen[i]) chosen[i] = true, ++done;
  std::vector<size_t> out;
  for (size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) out.push_back(i);
  return out;
}

}  // namespace cosplat
