#include "flame/fit/choose_person.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace cosplat {
namespace {

// Two boxes of one frame whose middles are closer than this, in units of their size, are one face.
constexpr double kOneFace = 0.3;
// What each frame without a person adds to the distance to where that person was, likewise.
constexpr double kForgotten = 0.2;
// What others are seen, in parts of the first.
constexpr double kAnother = 1. / 3;
// Who is in so many of the frames with faces comes before those who are not: too few frames make no
// track (CheckSkipped).
constexpr double kStays = 2. / 3;

// Someone who has been seen so far.
struct Seen {
  FaceBox last;
  size_t last_frame = 0;
  size_t frames = 0;
  double size = 0;   // px, sum over the frames
  double score = 0;  // likewise, less of what is far from where it is expected
  std::vector<std::optional<size_t>> face;
};

double DistanceOf(const FaceBox& a, const FaceBox& b) {
  const auto [ax, ay] = a.middle();
  const auto [bx, by] = b.middle();
  const double larger = std::max({a.size(), b.size(), 1e-6});
  const double smaller = std::max(std::min(a.size(), b.size()), 1e-6);
  return std::hypot(ax - bx, ay - by) / larger + std::log2(larger / smaller);
}

// Those of a frame's faces that are no smaller copy of another.
std::vector<size_t> DistinctFaces(const std::vector<FaceBox>& boxes) {
  std::vector<size_t> by_size(boxes.size());
  for (size_t i = 0; i < boxes.size(); ++i) by_size[i] = i;
  std::stable_sort(by_size.begin(), by_size.end(), [&](size_t a, size_t b) {
    return boxes[a].size() > boxes[b].size();
  });
  std::vector<size_t> distinct;
  for (const size_t i : by_size) {
    const auto [x, y] = boxes[i].middle();
    const bool copy = std::any_of(distinct.begin(), distinct.end(), [&, x = x, y = y](size_t k) {
      const auto [u, v] = boxes[k].middle();
      return std::hypot(x - u, y - v) < kOneFace * boxes[k].size();
    });
    if (!copy) distinct.push_back(i);
  }
  return distinct;
}

}  // namespace

Person ChoosePerson(const std::vector<std::vector<FaceBox>>& boxes,
                    const std::vector<FaceBox>& expected) {
  std::vector<Seen> people;
  size_t with_faces = 0;
  for (size_t f = 0; f < boxes.size(); ++f) {
    std::vector<size_t> faces = DistinctFaces(boxes[f]);
    with_faces += !faces.empty();
    std::vector<std::tuple<double, size_t, size_t>> pairs;  // distance, person, face
    for (size_t p = 0; p < people.size(); ++p)
      for (const size_t i : faces)
        pairs.emplace_back(DistanceOf(people[p].last, boxes[f][i]) +
                               kForgotten * double(f - people[p].last_frame - 1),
                           p,
                           i);
    std::sort(pairs.begin(), pairs.end());
    const auto see = [&](Seen& person, size_t i) {
      person.last = boxes[f][i];
      person.last_frame = f;
      const double size = boxes[f][i].size();
      ++person.frames;
      person.size += size;
      person.score +=
          expected.empty() ? size : size * std::exp(-DistanceOf(expected[f], boxes[f][i]));
      person.face[f] = i;
      std::erase(faces, i);
    };
    for (const auto& [distance, p, i] : pairs)
      if (!people[p].face[f] && std::count(faces.begin(), faces.end(), i) > 0) see(people[p], i);
    while (!faces.empty()) {
      people.emplace_back().face.resize(boxes.size());
      see(people.back(), faces.front());
    }
  }
  Person chosen;
  chosen.face.resize(boxes.size());
  chosen.others.resize(boxes.size());
  if (people.empty()) return chosen;
  const auto rank = [&](const Seen& person) {
    return std::pair(double(person.frames) >= kStays * double(with_faces), person.score);
  };
  const auto first =
      std::max_element(people.begin(), people.end(), [&](const Seen& a, const Seen& b) {
        return rank(a) < rank(b);
      });
  chosen.face = first->face;
  for (auto other = people.begin(); other != people.end(); ++other) {
    if (other == first || other->size < kAnother * first->size) continue;
    chosen.is_alone = false;
    for (size_t f = 0; f < boxes.size(); ++f)
      if (other->face[f]) chosen.others[f].push_back(boxes[f][*other->face[f]]);
  }
  return chosen;
}

Person KeepPerson(std::vector<std::vector<DetectedFace>>& frames,
                  const std::vector<FaceBox>& expected) {
  std::vector<std::vector<FaceBox>> boxes(frames.size());
  for (size_t f = 0; f < frames.size(); ++f)
    for (const DetectedFace& face : frames[f]) boxes[f].push_back(BoxOf(face.points));
  Person person = ChoosePerson(boxes, expected);
  for (size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].empty()) continue;
    if (!person.face[f]) {
      frames[f].clear();
      continue;
    }
    DetectedFace face = std::move(frames[f][*person.face[f]]);
    frames[f] = {std::move(face)};
  }
  return person;
}

}  // namespace cosplat
