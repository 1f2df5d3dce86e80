#include "flame/fit/choose_shots.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "flame/fit/face_looks.h"

namespace cosplat {
namespace {

constexpr double kMinShotSeconds = 1. / 6;
constexpr int kMinSamples = 2;  // of a shot: one face may be covered
// What an editor's zoom is at least. A face that speaks and turns changes its size by as much, but
// does so within a shot.
constexpr double kOtherSize = 1.2;

bool AreAlike(const FaceLook& a, const FaceLook& b) {
  return std::max(a.size, b.size) <= kOtherSize * std::min(a.size, b.size) &&
         FaceColorChange(a.colors, b.colors) <= kOtherFace;
}

}  // namespace

std::vector<Shot> ShotsBetween(const std::vector<int>& cuts, int frame_count, double rate) {
  std::vector<Shot> shots;
  int begin = 0;
  for (const int cut : cuts) {
    shots.push_back({begin, cut});
    begin = cut;
  }
  shots.push_back({begin, frame_count});
  std::vector<Shot> longer;
  for (const Shot& shot : shots)
    if (shot.count() >= kMinShotSeconds * rate) longer.push_back(shot);
  return longer.empty() ? shots : longer;
}

std::vector<int> SampleShots(const std::vector<Shot>& shots, int count) {
  int total = 0;
  for (const Shot& shot : shots) total += shot.count();
  std::vector<int> frames;
  for (const Shot& shot : shots) {
    const int share = int(std::ceil(double(count) * shot.count() / total));
    const int here = std::min(shot.count(), std::max(kMinSamples, share));
    for (int i = 0; i < here; ++i)
      frames.push_back(shot.begin + int((2LL * i + 1) * shot.count() / (2LL * here)));
  }
  return frames;
}

std::vector<size_t> ShotsAlike(const std::vector<Shot>& shots, const std::vector<FaceLook>& looks) {
  std::vector<std::vector<const FaceLook*>> of_shot(shots.size());
  for (const FaceLook& look : looks)
    for (size_t s = 0; s < shots.size(); ++s)
      if (look.frame >= shots[s].begin && look.frame < shots[s].end) of_shot[s].push_back(&look);
  // Each shot's group is named by the first that is in it.
  std::vector<size_t> group(shots.size());
  std::iota(group.begin(), group.end(), size_t(0));
  const auto alike = [&](size_t s, size_t t) {
    for (const FaceLook* a : of_shot[s])
      for (const FaceLook* b : of_shot[t])
        if (AreAlike(*a, *b)) return true;
    return false;
  };
  for (size_t s = 0; s < shots.size(); ++s)
    for (size_t t = 0; t < s; ++t) {
      const size_t from = group[s], to = group[t];
      if (from != to && alike(s, t))
        std::replace(group.begin(), group.end(), std::max(from, to), std::min(from, to));
    }
  std::vector<int> frames(shots.size());
  for (size_t s = 0; s < shots.size(); ++s)
    if (!of_shot[s].empty()) frames[group[s]] += shots[s].count();
  const size_t main = size_t(std::max_element(frames.begin(), frames.end()) - frames.begin());
  std::vector<size_t> chosen;
  for (size_t s = 0; s < shots.size(); ++s)
    if (!of_shot[s].empty() && group[s] == main) chosen.push_back(s);
  return chosen;
}

}  // namespace cosplat
