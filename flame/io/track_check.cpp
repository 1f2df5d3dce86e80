#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "flame/io/track_fit.h"
#include "flame/math/rodrigues.h"
#include "flame/pose.h"
#include "flame/track.h"
#include "splat/base/text.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

constexpr size_t kLookedAt = 24;       // frames, one of each part of the video
constexpr size_t kCandidates = 12;     // of a part: the one whose head moves most is looked at
constexpr int kSide = 256;             // px
constexpr double kFlat = 1.5;          // contrast, of 255
constexpr double kInside = 0.5;        // share of the head
constexpr float kGreatExpression = 6;  // standard deviations

std::string Of(size_t count, size_t all) {
  return std::to_string(count) + " of " + std::to_string(all) + " frames looked at";
}

void Project(const FlameModel& flame, const std::vector<float>& vertices, SeenFrame& seen) {
  const size_t count = size_t(flame.own_vertex_count());
  std::vector<Sighting> points(size_t(flame.vertex_count));
  std::vector<std::array<float, 3>> normals(points.size());
  for (size_t i = 0; i < points.size(); ++i) points[i] = Sight(seen.camera, &vertices[3 * i]);
  for (const auto& face : flame.faces) {
    const auto& a = points[size_t(face[0])].in_camera;
    const auto &b = points[size_t(face[1])].in_camera, &d = points[size_t(face[2])].in_camera;
    float u[3], v[3];
    for (size_t k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = d[k] - a[k];
    for (size_t k = 0; k < 3; ++k) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      for (const int corner : face) normals[size_t(corner)][k] += u[i] * v[j] - u[j] * v[i];
    }
  }
  seen.visible.resize(count);
  size_t inside = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto &p = points[i].in_camera, &n = normals[i];
    inside += points[i].inside;
    const float towards = -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]);
    seen.visible[i] = points[i].inside &&
                      towards > 0.5f * std::hypot(n[0], n[1], n[2]) * std::hypot(p[0], p[1], p[2]);
  }
  seen.share_inside = count == 0 ? 1 : double(inside) / double(count);
  points.resize(count);
  seen.points = std::move(points);
}

// Sum of the distances in px, of every eighth vertex.
double Motion(const SeenFrame& a, const SeenFrame& b) {
  double sum = 0;
  for (size_t i = 0; i < a.points.size(); i += 8)
    sum += std::hypot(a.points[i].x - b.points[i].x, a.points[i].y - b.points[i].y);
  return sum;
}

// VHAP's offsets have rows for teeth that a model may lack.
FlamePoser<float> PoserOf(const FlameModel& flame, const TrackedVideo& video) {
  std::vector<float> offset = video.static_offset;
  if (!offset.empty()) offset.resize(3 * size_t(flame.vertex_count));
  return FlamePoser<float>(flame, video.shape, offset);
}

std::vector<float> Posed(const FlamePoser<float>& poser,
                         const FlameModel& flame,
                         const TrackedFrame& frame) {
  FlameParams params = frame.params;
  params.expression.resize(std::min(params.expression.size(), size_t(flame.expression_count)));
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  return vertices;
}

// From each part of the video the frame whose head has moved most since the frame before, since
// motion shows what does not agree.
// Less those whose image cannot be used.
std::vector<SeenFrame> LookAt(const FlameModel& flame,
                              const TrackedVideo& video,
                              std::vector<SkippedFrame>& skipped) {
  std::vector<const TrackedFrame*> frames = InstantsOf(video);
  std::erase_if(frames, [](const TrackedFrame* frame) { return !frame->has_image; });
  const FlamePoser<float> poser = PoserOf(flame, video);
  const auto seen_at = [&](size_t i) {
    SeenFrame seen;
    seen.frame = frames[i];
    const Camera& camera = frames[i]->camera;
    const double scale = std::min(1.0, double(kSide) / std::max(camera.width, camera.height));
    seen.camera = camera.Resized(std::max(1, int(scale * camera.width)),
                                 std::max(1, int(scale * camera.height)));
    Project(flame, Posed(poser, flame, *frames[i]), seen);
    return seen;
  };
  std::vector<SeenFrame> all;
  std::vector<size_t> at;
  const size_t n = frames.size(), ends = n > 2 * kShifts ? kShifts : 0, middle = n - 2 * ends,
               parts = std::min(kLookedAt, middle);
  for (size_t part = 0; part < parts; ++part) {
    const size_t first = ends + part * middle / parts, last = ends + (part + 1) * middle / parts;
    SeenFrame before = seen_at(first > 0 ? first - 1 : 0), best;
    double max = -1;
    at.push_back(first);
    for (size_t i = first; i < std::min(last, first + kCandidates); ++i) {
      SeenFrame seen = seen_at(i);
      const double motion = Motion(before, seen);
      before = seen;
      if (motion <= max) continue;
      max = motion, best = std::move(seen), at.back() = i;
    }
    all.push_back(std::move(best));
  }
  std::vector<std::string> problems(all.size());  // of their own images
  const auto load = [&](size_t k) {
    for (int shift = -kShifts; shift <= kShifts; ++shift) {
      const ptrdiff_t i = ptrdiff_t(at[k]) + shift;
      if (i < 0 || i >= ptrdiff_t(n)) continue;
      const std::string problem = Problem([&] {
        all[k].images[size_t(kShifts + shift)] =
            ReducedTo(LoadTrackedImage(video, *frames[size_t(i)]), kSide);
      });
      if (shift == 0) problems[k] = problem;
    }
  };
  if (video.video)  // in order: it is decoded from its beginning
    for (size_t k = 0; k < all.size(); ++k) load(k);
  else
    tbb::parallel_for(size_t(0), all.size(), load);
  const auto name_of = [](const SeenFrame& seen) { return seen.frame->name; };
  return KeepUsable(std::move(all), problems, name_of, skipped);
}

// How many frames a condition holds for, and the first of them.
struct Count {
  size_t frames = 0;
  std::string first;
  void Add(const SeenFrame& seen) {
    if (frames++ == 0) first = seen.frame->name;
  }
};

void CheckImages(const std::vector<SeenFrame>& all, std::vector<Finding>& findings) {
  Count outside, flat, empty, repeated;
  for (const SeenFrame& seen : all) {
    if (seen.share_inside < kInside) outside.Add(seen);
    if (GreatestAlpha(seen.image()) == 0)
      empty.Add(seen);
    else if (ContrastOf(seen.image()) < kFlat)
      flat.Add(seen);
    else if (seen.images[kShifts - 1].data == seen.image().data)
      repeated.Add(seen);
  }
  const auto say = [&](const Count& count, const std::string& what) {
    if (count.frames > 0)
      findings.push_back(
          {2 * count.frames >= all.size(),
           "in " + Of(count.frames, all.size()) + " " + what + " (first: " + count.first + ")"});
  };
  say(outside, "less than half of the head is inside the image: look at camera and focal length");
  say(empty, "the mask shows nothing: look at the masks");
  say(flat, "the image is nearly of one colour: there is nothing to learn from it");
  say(repeated, "the image is that of the frame before: look at the image files");
}

// By the numbers of all frames.

void CheckLenses(const std::vector<const TrackedFrame*>& frames, std::vector<Finding>& findings) {
  size_t wrong = 0;
  std::string first;
  for (const TrackedFrame* frame : frames) {
    const std::string problem = LensProblem(frame->camera);
    if (!problem.empty() && wrong++ == 0) first = frame->name + ": " + problem;
  }
  if (wrong > 0)
    findings.push_back({true,
                        std::to_string(wrong) + " of " + std::to_string(frames.size()) +
                            " cameras have intrinsics that no video has (" + first + ")"});
}

// What is the same in two frames only if one is the other.
using FrameKey = std::tuple<std::vector<float>,
                            std::array<std::array<float, 3>, kFlameJoints>,
                            std::array<float, 3>,
                            std::array<float, 9>,
                            std::array<float, 3>>;
FrameKey KeyOf(const TrackedFrame& frame) {
  return {frame.params.expression,
          frame.params.pose,
          frame.params.translation,
          frame.camera.rotation,
          frame.camera.translation};
}

void CheckCount(const TrackedVideo& video, std::vector<Finding>& findings) {
  constexpr size_t kFewFrames = 10;
  if (video.train.size() < kFewFrames)
    findings.push_back({false,
                        std::to_string(video.train.size()) + " training frame" +
                            (video.train.size() == 1 ? "" : "s") +
                            ": an avatar shows what it was shown; film ten seconds and more, with "
                            "turns and speech"});
}

// A head that lies on its side: a video that was filmed or stored turned.
void CheckUpright(const std::vector<const TrackedFrame*>& frames, std::vector<Finding>& findings) {
  size_t lying = 0;
  for (const TrackedFrame* frame : frames) {
    const auto root = flame_math::Rodrigues(math::ToVec3(frame->params.pose[0]));
    float up[3] = {};  // the head's, in the camera's axes
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) up[r] += frame->camera.rotation[size_t(3 * r + k)] * root(k, 1);
    const float in_image = std::hypot(up[0], up[1]);
    lying += in_image > 0.5f && -up[1] < 0.5f * in_image;  // by more than 60 degrees
  }
  if (2 * lying > frames.size())
    findings.push_back({true,
                        "the head is on its side or upside down in " + std::to_string(lying) +
                            " of " + std::to_string(frames.size()) +
                            " frames: is the video turned?"});
}

// Images that differ although the track says that nothing moved.
void CheckMotion(const std::vector<const TrackedFrame*>& frames,
                 const std::vector<SeenFrame>& all,
                 std::vector<Finding>& findings) {
  constexpr double kMoved = 2;  // of 255
  const FrameKey first = KeyOf(*frames.front());
  for (const TrackedFrame* frame : frames)
    if (KeyOf(*frame) != first) return;
  double moved = 0;
  for (const SeenFrame& seen : all)
    moved = std::max(moved, DifferenceOf(GlanceOf(seen.image()), GlanceOf(all[0].image())));
  if (moved > kMoved)
    findings.push_back({true,
                        "all " + std::to_string(frames.size()) +
                            " frames have the same pose and expression, and their images differ: "
                            "look at the files that the track names for its frames"});
}

// By file, or by a track and an image that are equal.
void CheckTestFrames(const TrackedVideo& video, std::vector<Finding>& findings) {
  std::map<std::string, const TrackedFrame*> files;
  std::map<FrameKey, const TrackedFrame*> tracked;
  for (const TrackedFrame& frame : video.train) {
    if (!frame.image_path.empty()) files[frame.image_path] = &frame;
    tracked[KeyOf(frame)] = &frame;
  }
  size_t same = 0;
  std::string first;
  for (const TrackedFrame& frame : video.test) {
    const TrackedFrame* train = nullptr;
    if (const auto file = files.find(frame.image_path); file != files.end()) {
      train = file->second;
    } else if (const auto track = tracked.find(KeyOf(frame));
               track != tracked.end() && frame.video_frame < 0) {
      Problem([&] {  // what cannot be read is said elsewhere
        if (LoadTrackedImage(video, frame).data == LoadTrackedImage(video, *track->second).data)
          train = track->second;
      });
    }
    if (train && same++ == 0) first = frame.name + " and " + train->name;
  }
  if (same > 0)
    findings.push_back({true,
                        std::to_string(same) + " of " + std::to_string(video.test.size()) +
                            " test frames are training frames, too (" + first +
                            "): their figures say nothing of unseen frames"});
}

// Share of the head's points that masks hold.
void CheckMasks(const std::vector<SeenFrame>& all, std::vector<Finding>& findings) {
  double held = 0, points = 0;
  for (const SeenFrame& seen : all) {
    if (seen.image().channels != 4) continue;
    for (const Sighting& point : seen.points)
      if (point.inside) {
        held += seen.image().at(int(point.x), int(point.y), 3) / 255.0;
        ++points;
      }
  }
  if (points > 0 && held < kInside * points)
    findings.push_back({true,
                        "the masks hold only " + Format("{:.0f}", 100 * held / points) +
                            " % of the head where the track says it is: look at masks, images and "
                            "cameras"});
}

// Frames without a mask, or with one that holds all of the image, among those with one.
void CheckCuts(const TrackedVideo& video,
               const std::vector<SeenFrame>& all,
               std::vector<Finding>& findings) {
  Count cut, whole;
  size_t trained = 0, trained_cut = 0;
  for (const SeenFrame& seen : all) {
    const bool is_cut = SmallestAlpha(seen.image()) < 255;
    (is_cut ? cut : whole).Add(seen);
    const bool in_training =
        seen.frame >= video.train.data() && seen.frame < video.train.data() + video.train.size();
    trained += in_training, trained_cut += in_training && is_cut;
  }
  if (cut.frames == 0 || whole.frames == 0) return;
  const bool between = 4 * trained_cut >= 3 * trained && trained < all.size() &&
                       4 * (cut.frames - trained_cut) <= all.size() - trained;
  findings.push_back(
      {between || 4 * whole.frames >= all.size(),
       "in " + Of(whole.frames, all.size()) +
           " the background is not cut out, in the others it is (first: " + whole.first +
           "): look at the masks" + (between ? " of the test frames" : "")});
}

void CheckExpressions(const FlameModel& flame,
                      const std::vector<SeenFrame>& all,
                      std::vector<Finding>& findings) {
  Count great, more;
  float greatest = 0;
  size_t max = 0;
  for (const SeenFrame& seen : all) {
    const std::vector<float>& e = seen.frame->params.expression;
    float frame_greatest = 0;
    for (const float value : e) frame_greatest = std::max(frame_greatest, std::abs(value));
    if (frame_greatest > kGreatExpression) great.Add(seen);
    greatest = std::max(greatest, frame_greatest);
    size_t used = e.size();
    while (used > 0 && e[used - 1] == 0) --used;
    if (used > size_t(flame.expression_count)) more.Add(seen);
    max = std::max(max, used);
  }
  if (8 * great.frames > all.size())
    findings.push_back({2 * great.frames >= all.size(),
                        "in " + Of(great.frames, all.size()) +
                            " expressions go beyond 6 standard deviations (to " +
                            Format("{:.1f}", greatest) + ", first: " + great.first +
                            "): is it the tracker's model?"});
  if (more.frames > 0)
    findings.push_back({false,
                        "the track has " + std::to_string(max) +
                            " expression coefficients, and the model " +
                            std::to_string(flame.expression_count) +
                            ": the rest is not used; pass the tracker's model"});
}

}  // namespace

std::vector<float> TrackedVertices(const FlameModel& flame,
                                   const TrackedVideo& video,
                                   const TrackedFrame& frame) {
  return Posed(PoserOf(flame, video), flame, frame);
}

std::vector<Finding> CheckTrack(const FlameModel& flame, const TrackedVideo& video) {
  std::vector<Finding> findings;
  std::vector<const TrackedFrame*> frames;
  for (const auto* list : {&video.train, &video.test})
    for (const TrackedFrame& frame : *list)
      if (frame.has_image) frames.push_back(&frame);
  if (frames.empty()) return findings;
  CheckCount(video, findings);
  CheckLenses(frames, findings);
  CheckUpright(frames, findings);
  CheckTestFrames(video, findings);
  std::vector<SkippedFrame> skipped;
  const std::vector<SeenFrame> all = LookAt(flame, video, skipped);
  if (all.empty() && !skipped.empty()) CheckSkipped(video.source, 0, skipped);
  NoteSkipped(all.size(), skipped, "frames looked at", findings);
  if (all.empty()) return findings;
  CheckImages(all, findings);
  CheckMotion(frames, all, findings);
  CheckCuts(video, all, findings);
  CheckMasks(all, findings);
  CheckPlace(flame, all, findings);
  CheckHeadColors(flame, all, findings);
  CheckExpressions(flame, all, findings);
  return findings;
}

}  // namespace cosplat
