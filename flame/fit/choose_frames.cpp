#include "flame/fit/choose_frames.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "flame/fit/landmark_scores.h"
#include "flame/io/landmarks.h"
#include "splat/base/median.h"

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

// The first frames of a video that are not for testing, the usable ones first.
std::vector<size_t> Usable(const LandmarkVideo& seen, const std::vector<double>& sharpness) {
  std::vector<double> sharp;
  const size_t count = seen.frames.size() - size_t(seen.held_out);
  for (size_t i = 0; i < count; ++i)
    if (!seen.frames[i].faces.empty()) sharp.push_back(sharpness[i]);
  if (sharp.empty()) return {};
  const double least = kBlurred * Median(sharp);
  std::vector<size_t> usable;
  for (size_t i = 0; i < count; ++i)
    if (!seen.frames[i].faces.empty() && sharpness[i] >= least) usable.push_back(i);
  return usable;
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
  for (const size_t i : usable) looks.push_back(LookOf(seen.frames[i].faces[0], seen.set));
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
