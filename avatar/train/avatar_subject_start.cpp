// Initialisation of an avatar's training: frames, mesh and first Gaussians.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "avatar/math/turn.h"
#include "avatar/model/corrections.h"
#include "avatar/play/player.h"
#include "avatar/surface/sample.h"
#include "avatar/surface/silhouette.h"
#include "avatar/train/avatar_subject.h"
#include "avatar/train/painted_mesh.h"
#include "avatar/train/virtual_views.h"
#include "flame/mouth.h"
#include "splat/base/error.h"
#include "splat/math/scalar.h"
#include "splat/train/start/initialize.h"

namespace cosplat {
namespace {

// Training frames that show the mesh's colours, evenly chosen.
constexpr size_t kPaintFrames = 40;

// Virtual views of a short video; and for how many there is a wide one.
constexpr size_t kFewestViews = 6, kVirtualPerWide = 3;
// Faces with an open mouth, at most: however long a video is, there are no more kinds of them.
constexpr size_t kMostFaces = 200;

constexpr float kInitialOpacity = 0.1f;  // SplattingAvatar

// A bust is added if more than this fraction of the masks' area lies outside the head's mesh.
constexpr double kBustShare = 0.1;
constexpr size_t kBustFrames = 5;

// Training frames over which the light's terms are averaged, evenly chosen; a frame takes less than
// a millisecond.
constexpr size_t kLightFrames = 1000;

TrackedVideo WithOffsetFor(const FlameModel& flame, TrackedVideo video) {
  video.static_offset = StaticOffsetFor(flame, std::move(video.static_offset));
  return video;
}

}  // namespace

AvatarSubject::AvatarSubject(const FlameModel& flame,
                             TrackedVideo video,
                             const AvatarSettings& settings)
    : flame_(flame),
      video_(WithOffsetFor(flame, std::move(video))),
      settings_(settings),
      subject_(MakeCanonicalMesh(flame, video_.shape, video_.static_offset, {})),
      surface_(subject_.mesh) {
  if (settings_.refine_track && settings_.system == AvatarSystem::kReleased)
    throw Error("--refine-track",
                "is not supported with the rule of SplattingAvatar's released code");
  LoadFrames();
  if (settings_.bust == AvatarSettings::BustChoice::kYes ||
      (settings_.bust == AvatarSettings::BustChoice::kAuto && NeedsBust()))
    subject_.bust = MeanBustOfTrack();
  if (settings_.system != AvatarSystem::kCosplat) subject_.canonical_frame = video_.train[0].params;
  if (subject_.bust || subject_.canonical_frame) BuildMesh();
  track_.poser =
      std::make_unique<AvatarPoser>(flame, video_.shape, video_.static_offset, subject_.bust);
  if (subject_.bust && IsOurs() && !settings_.still_bust) StartBustTrack();
  if (settings_.corrections > 0) {
    std::vector<FlamePoser<float>::Parameters> frames;
    for (const RefinedFrame& frame : track_.frames) frames.push_back(frame.params);
    correction_map_ = FindCorrectionMap(flame, frames, settings_.corrections);
  }
  if (IsOurs() && settings_.light_rate > 0) StartLight();
  SetFaceRates();
  AddVirtualViews();
  posed_vertices_ = PosedVertices(FaceCount(), surface_.vertex_count(), 0);
}

// du and dv have the learning rate of d in metres: a barycentric unit is about sqrt(2 A) long. For
// SplattingAvatar they have the number that it uses for d, whose unit is the subject's extent.
void AvatarSubject::SetFaceRates() {
  for (size_t f = 0; f < subject_.mesh.faces.size(); ++f)
    face_rates_.push_back(
        settings_.system == AvatarSystem::kCosplat
            ? float(1 / std::sqrt(2 * std::max(FaceArea(subject_.mesh, f), 1e-12)))
            : 1 / subject_.unit);
}

void AvatarSubject::LoadFrames() {
  std::vector<Image8> images(video_.train.size());
  std::vector<std::string> problems(video_.train.size());
  const auto load = [&](size_t i) {
    problems[i] = Problem([&] { images[i] = LoadTrackedImage(video_, video_.train[i]); });
  };
  if (video_.video) {  // a video file must be decoded in order
    for (size_t i = 0; i < images.size(); ++i) load(i);
  } else {
    tbb::parallel_for(size_t(0), images.size(), load);
  }
  for (size_t i = 0; i < images.size(); ++i) {
    if (!problems[i].empty()) continue;
    const TrackedFrame& frame = video_.train[i];
    frames_.push_back({frame.camera, std::move(images[i])});
    track_.frames.push_back(
        {{FlamePoser<float>::ParametersOf(frame.params)}, size_t(flame_.expression_count)});
  }
  const auto name_of = [](const TrackedFrame& frame) { return frame.name; };
  video_.train = KeepUsable(std::move(video_.train), problems, name_of, video_.skipped);
  CheckSkipped(video_.source, frames_.size() + video_.test.size(), video_.skipped);
  if (frames_.empty())
    throw Error(video_.source, "training frames", "none is usable: " + video_.skipped[0].reason);
}

// Whether a large part of the masks lies outside the mesh. Hair does too, but far less than a bust.
bool AvatarSubject::NeedsBust() const {
  AvatarPoser head(flame_, video_.shape, video_.static_offset, {});
  std::vector<float> vertices;
  size_t shown = 0, beyond = 0;
  for (size_t k = 0; k < std::min(kBustFrames, frames_.size()); ++k) {
    const size_t f = k * frames_.size() / kBustFrames;
    const Image8& target = frames_[f].target;
    if (target.channels != 4) return false;  // no masks
    head.Forward(track_.frames[f].params, vertices);
    const std::vector<uint8_t> covered = MeshSilhouette(vertices, flame_.faces, frames_[f].camera);
    for (size_t p = 0; p < covered.size(); ++p) {
      if (target.data[4 * p + 3] < 128) continue;
      ++shown;
      beyond += !covered[p];
    }
  }
  return shown > 0 && double(beyond) > kBustShare * double(shown);
}

Bust AvatarSubject::MeanBustOfTrack() const {
  std::vector<FlameParams> track;
  for (const TrackedFrame& frame : video_.train) track.push_back(frame.params);
  return MeanBust(flame_, video_.shape, video_.static_offset, track);
}

// An alpha that is opaque in all frames is that of a file format, not a mask.
bool AvatarSubject::IsMasked() const {
  const auto shows_background = [](const TrainFrame& frame) {
    for (size_t i = 3; i < frame.target.data.size(); i += 4)
      if (frame.target.data[i] < 128) return true;
    return false;
  };
  return std::all_of(frames_.begin(),
                     frames_.end(),
                     [](const TrainFrame& frame) { return frame.target.channels == 4; }) &&
         std::any_of(frames_.begin(), frames_.end(), shows_background);
}

void AvatarSubject::StartBustTrack() {
  std::vector<int> timesteps;
  for (const TrackedFrame& frame : video_.train) timesteps.push_back(frame.timestep);
  const std::vector<size_t> instants = InstantsOf(timesteps);
  std::vector<BustPose> poses(*std::max_element(instants.begin(), instants.end()) + 1,
                              kMeanBustPose);
  // With several cameras, images of different ones cannot be compared.
  if (IsMasked() && poses.size() == frames_.size()) {
    std::vector<std::vector<float>> vertices;
    for (size_t i = 0; i < frames_.size(); ++i) vertices.push_back(track_.VerticesOf(i));
    const std::vector<BustPose> of_frames = RegisterBusts(*track_.poser, frames_, vertices);
    for (size_t i = 0; i < frames_.size(); ++i) poses[instants[i]] = of_frames[i];
  }
  BustRates rates = settings_.bust_rates;
  rates.shift *= kEnlarged * subject_.unit;
  bust_track_ = BustTrack(*track_.poser, poses, instants, rates, settings_.iterations);
}

void AvatarSubject::StartLight() {
  Surface posed(subject_.mesh);
  LightMean mean(posed.vertex_count());
  const size_t step = 1 + (frame_count() - 1) / kLightFrames;
  for (size_t i = 0; i < frame_count(); i += step) {
    posed.Pose(track_.VerticesOf(i));
    mean.Add(posed);
  }
  light_ = LightFit(mean.Mean(), settings_.light_rate, settings_.iterations);
}

void AvatarSubject::AddVirtualViews() {
  const size_t real = frames_.size();
  const float share = settings_.virtual_views;
  const size_t count = std::max(size_t(share / (1 - share) * float(real)), kFewestViews);
  std::vector<HeadInFrame> heads;
  for (size_t i = 0; i < real; ++i) {
    const std::vector<float>& vertices = track_.VerticesOf(i);
    const HeadPlace place = PlaceOfHead({vertices.data(), 3 * size_t(flame_.vertex_count)},
                                        video_.train[i].params.pose[0]);
    heads.push_back({place.center,
                     place.world_from_head *
                         math::RotationOf(math::QuatOfAxisAngle(video_.train[i].params.pose[1])),
                     frames_[i].camera});
  }
  filmed_ = FilmedFromOf(heads);
  if (!IsOurs() || !IsMasked() || share == 0) return;
  std::vector<MeshInFrame> learned, sources;
  for (size_t i = 0; i < real; i += 1 + (real - 1) / kPaintFrames) learned.push_back(MeshIn(i));
  const PaintedMesh painted(flame_, subject_.mesh, learned, kEnlarged * subject_.unit);
  filmed_.guessed = painted.GuessedShare();
  const std::vector<VirtualView> views = ChooseVirtualViews(heads, count);
  for (const VirtualView& view : views) sources.push_back(MeshIn(view.source));
  std::vector<TrainFrame> seen(views.size());
  tbb::parallel_for(size_t(0), views.size(), [&](size_t k) {
    seen[k] = ToVirtualView(views[k], sources[k], painted);
  });
  AddVirtualFaces(painted, std::min(count, kMostFaces));
  for (const VirtualView& view : views) view_sources_.push_back(view.source);
  AddWideViews(painted, count / kVirtualPerWide, seen);
  std::move(seen.begin(), seen.end(), std::back_inserter(frames_));
}

MeshInFrame AvatarSubject::MeshIn(size_t i) {
  if (!bust_track_.empty()) track_.frames[i].params.bust = bust_track_.PoseOf(i);
  return {&frames_[i], track_.VerticesOf(i)};
}

// Also finds what is far beyond all frames, however few show it.
void AvatarSubject::AddWideViews(const PaintedMesh& painted,
                                 size_t count,
                                 std::vector<TrainFrame>& views) {
  std::vector<BodyInFrame> bodies;
  std::vector<size_t> sources;
  std::vector<uint8_t> in_frame(surface_.vertex_count(), 0);
  bool is_cut = false;
  for (size_t i = 0; i < track_.frames.size(); ++i) {
    const Camera& camera = frames_[i].camera;
    const MeshInFrame seen = MeshIn(i);
    for (size_t v = 0; v < in_frame.size(); ++v)
      in_frame[v] |= InFrameShare(camera, Project(camera, seen.Vertex(v)), painted.scale()) > 0;
    const BodyInFrame body = painted.BodyIn(seen);
    if (!(Project(camera, body.anchor).depth > camera.near_plane)) continue;
    bodies.push_back(body);
    sources.push_back(i);
    is_cut = is_cut || ReachesBorder(frames_[i]);
  }
  for (const std::array<int32_t, 3>& f : subject_.mesh.faces)
    beyond_frames_.push_back(
        std::none_of(f.begin(), f.end(), [&](int32_t v) { return in_frame[size_t(v)] != 0; }));
  if (!is_cut) return;
  const FilmedBox box = FilmedBoxOf(bodies);
  for (size_t k = 0; k < count; ++k) {
    const size_t of = k * bodies.size() / count;
    views.push_back(ToWideView(bodies[of], box, painted.scale()));
    view_sources_.push_back(sources[of]);
  }
}

void AvatarSubject::AddVirtualFaces(const PaintedMesh& painted, size_t count) {
  std::vector<AvatarPoser::Parameters> track;
  std::vector<Camera> cameras;
  for (size_t i = 0; i < track_.frames.size(); ++i) {
    track.push_back(track_.frames[i].params);
    cameras.push_back(frames_[i].camera);
  }
  const VirtualFaces chosen = ChooseVirtualFaces(flame_, *track_.poser, track, cameras, count);
  std::vector<MeshInFrame> sources;
  std::vector<std::vector<float>> vertices;
  for (const VirtualFace& face : chosen.faces) {
    sources.push_back(MeshIn(face.source));
    vertices.push_back(track_.VerticesOf(face.params));
  }
  std::vector<std::optional<TrainFrame>> shown(sources.size());
  tbb::parallel_for(size_t(0), sources.size(), [&](size_t k) {
    shown[k] = ToVirtualFace(sources[k], vertices[k], chosen.known, painted);
  });
  for (size_t k = 0; k < shown.size(); ++k) {
    if (!shown[k]) continue;
    frames_.push_back(std::move(*shown[k]));
    other_faces_.push_back(chosen.faces[k]);
  }
}

void AvatarSubject::BuildMesh() {
  subject_.mesh = MakeCanonicalMesh(
      flame_, video_.shape, video_.static_offset, subject_.bust, subject_.canonical_frame);
  surface_ = Surface(subject_.mesh);
}

// Sets the initial scales from the Gaussians' spacing.
void AvatarSubject::SetSpacing(Gaussians& g) {
  if (settings_.system == AvatarSystem::kCosplat) {
    // Evenly spread: the spacing is the square root of each Gaussian's equal share of the area.
    const float spacing =
        float(std::sqrt(SurfaceArea(subject_.mesh) / double(settings_.initial_gaussians)));
    for (float& s : g.values[kScaleLog]) s = std::log(spacing);
    return;
  }
  // In units of the enlarged mesh, because of the minimum distance in 3DGS's initialisation.
  std::vector<float> points;
  for (const float x : Centers(g, *stream_)) points.push_back(x / subject_.unit);
  const std::vector<uint8_t> grey(points.size(), 128);
  g.values[kScaleLog] = InitializeFromPoints(points, grey, 0, g.basis).values[kScaleLog];
  for (float& s : g.values[kScaleLog]) s += std::log(subject_.unit);
}

Gaussians AvatarSubject::InitialGaussians(int degree, Basis basis, uint64_t seed) {
  Rng rng{seed};
  Gaussians g;
  g.degree = degree;
  g.basis = basis;
  g.corrections = int(correction_map_.count());
  const bool released = settings_.system == AvatarSystem::kReleased;
  Embedding embedding;
  if (released) embedding.released = ReleasedRule{subject_.unit};
  const size_t count = settings_.initial_gaussians;
  // A track that is wrong may see nothing of the head at all.
  const bool leaves_out =
      std::find(beyond_frames_.begin(), beyond_frames_.end(), false) != beyond_frames_.end();
  for (const SurfacePoint& p : released ? SampleFaces(subject_.mesh, count, rng)
                                        : SampleSurface(subject_.mesh, count, rng)) {
    if (leaves_out && beyond_frames_[size_t(p.triangle)]) continue;
    embedding.triangle.push_back(p.triangle);
    embedding.barycentric.push_back(p.barycentric);
  }
  g.Resize(embedding.triangle.size());
  embedded_ = EmbeddedGaussians(embedding, embedding.triangle, face_rates_, *stream_);
  for (size_t i = 0; i < g.size(); ++i) {
    g.at(kRotation, i)[0] = 1;
    g.at(kOpacityLogit, i)[0] = math::Logit(kInitialOpacity);
  }
  SetSpacing(g);
  return g;
}

}  // namespace cosplat
