#include "avatar/plugin/instance_face.h"

#include "avatar/plugin/coded_error.h"
#include "splat/base/text.h"

namespace cosplat::plugin {
namespace {

static_assert(kMaxParameter == COSPLAT_LARGEST_PARAMETER);
static_assert(uint32_t(FaceState::kRest) == COSPLAT_FACE_REST &&
              uint32_t(FaceState::kLive) == COSPLAT_FACE_LIVE &&
              uint32_t(FaceState::kDecaying) == COSPLAT_FACE_DECAYING &&
              uint32_t(FaceState::kReturning) == COSPLAT_FACE_RETURNING);

// Numbers outside these limits are mistakes and would lose precision.
constexpr float kMinSeconds = 1e-6f, kMaxSeconds = 1e6f;
constexpr float kMinCutoff = 1e-3f, kMaxCutoff = 1e4f;
constexpr float kMaxBeta = 1e4f;

float Within(float value, float min, float max, double otherwise, const char* field) {
  if (value == 0) return float(otherwise);
  if (!(value >= min && value <= max))
    Refuse(field, Format("{} is neither 0 nor from {} to {}", value, min, max));
  return value;
}

bool Flag(uint32_t value, const char* field) {
  if (value > 1) Refuse(field, std::to_string(value) + " is neither 0 nor 1");
  return value == 1;
}

GuardPolicy PolicyOf(const cosplat_policy& given) {
  GuardPolicy policy;
  const auto seconds = [](float value, double otherwise, const char* field) {
    return double(Within(value, kMinSeconds, kMaxSeconds, otherwise, field));
  };
  policy.hold = seconds(given.hold_s, policy.hold, "policy.hold_s");
  policy.decay = seconds(given.decay_s, policy.decay, "policy.decay_s");
  policy.blend_in = seconds(given.blend_in_s, policy.blend_in, "policy.blend_in_s");
  policy.soft_range = !Flag(given.range, "policy.range");
  math::OneEuro filter;
  filter.min_cutoff = Within(
      given.min_cutoff_hz, kMinCutoff, kMaxCutoff, filter.min_cutoff, "policy.min_cutoff_hz");
  filter.beta = Within(given.beta, 0, kMaxBeta, filter.beta, "policy.beta");
  if (Flag(given.smoothing, "policy.smoothing")) policy.smoothing = filter;
  return policy;
}

}  // namespace

InstanceFace::InstanceFace(const FlameParams& rest,
                           const FlameModel& flame,
                           const AvatarModel& avatar)
    : guard_(rest, avatar.trained_range) {
  source_options_.rest = rest;
  source_options_.flame = &flame;
  if (avatar.blendshapes) source_options_.blendshapes = &*avatar.blendshapes;
}

void InstanceFace::SetPolicy(const cosplat_policy& given) {
  const GuardPolicy policy = PolicyOf(given);
  const bool loop = Flag(given.loop, "policy.loop");
  source_options_.frames_per_second =
      Within(given.frames_per_second, 1e-3f, 1e4f, 0, "policy.frames_per_second");
  source_options_.loop = loop;
  guard_.SetPolicy(policy);
}

void InstanceFace::SetDrive(const char* drive) {
  try {
    source_ = drive ? OpenLiveSource(drive, source_options_) : nullptr;
  } catch (const Error& error) {
    throw CodedError(COSPLAT_ERROR_DRIVE, error.what());
  }
}

void InstanceFace::Offer(const LiveParameters& parameters) {
  guard_.Offer(parameters.current(), parameters.time_ns());
}

void InstanceFace::Advance(int64_t now_ns, LiveParameters& parameters) {
  if (shown_ && now_ns < now_ns_)
    throw CodedError(COSPLAT_ERROR_LATE,
                     "now_ns",
                     std::to_string(now_ns) + " is earlier than the previous cosplat_advance (" +
                         std::to_string(now_ns_) + "); call cosplat_reset_parameters to restart");
  if (source_ && source_->Poll(now_ns, frame_) &&
      guard_.Offer(frame_.params, frame_.time_ns) == Verdict::kAccepted)
    parameters.Keep(frame_.params, frame_.time_ns);
  shown_ = &guard_.At(now_ns);
  now_ns_ = now_ns;
}

void InstanceFace::Reset() {
  guard_.Reset();
  shown_ = nullptr;
}

cosplat_health InstanceFace::Health() {
  const LiveCounts drive = source_ ? source_->Counts() : LiveCounts{};
  description_ = source_ ? source_->Description() : "";
  problem_ = drive.last_problem;
  notes_ = NotesOf(drive);
  const GuardCounts& face = guard_.counts();
  cosplat_health out{};
  out.face = uint32_t(guard_.state());
  out.age_s = float(guard_.Age());
  out.accepted = face.accepted;
  out.replaced = face.replaced;
  out.late = face.late;
  out.not_finite = face.not_finite;
  out.out_of_range = face.out_of_range;
  out.wrong_size = face.wrong_size;
  out.softened = face.softened;
  out.held = face.held;
  out.decayed = face.decayed;
  out.returned = face.returned;
  out.drive_frames = drive.frames;
  out.drive_replaced = drive.replaced;
  out.drive_reordered = drive.reordered;
  out.drive_malformed = drive.malformed;
  out.drive_oversize = drive.oversize;
  out.drive_flooded = drive.flooded;
  out.drive_ended = source_ && source_->Ended();
  out.drive = description_.c_str();
  out.drive_problem = problem_.c_str();
  out.drive_packets = drive.packets;
  out.drive_unusable = drive.unusable;
  out.drive_notes = notes_.c_str();
  return out;
}

}  // namespace cosplat::plugin
