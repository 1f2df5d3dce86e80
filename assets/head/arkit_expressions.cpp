// ARKit's blendshapes as directions of the head, each by what Apple's documentation says it does.
//
// Amounts here are those of a score of 1; the directions are scaled so that coefficients of faces
// are about 1, as FLAME's. Jaw and gaze are turns of joints (GeneralBlendshapeMap); of
// the gaze, the directions are what the lids do. There is no tongueOut.
// Source: Apple, ARFaceAnchor.BlendShapeLocation.

#include <algorithm>
#include <cmath>
#include <string>

#include "assets/head/procedural_head.h"
#include "assets/head/rig.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

enum class Lip { kAny, kUpper, kLower };  // what moves, of the mouth

// One smooth field of a direction: a bell, in millimetres. Those of a pair are its left side.
struct Move {
  const char* name;
  Vec at;     // its middle
  Vec width;  // of the bell, along each axis
  Vec by;     // outwards, up, forward
  Lip lip = Lip::kAny;
};

// Each is two directions, ...Left and ...Right.
constexpr Move kPaired[] = {
    {"mouthSmile", {27, -41, 53}, {18, 17, 20}, {7, 9, -8}},
    {"mouthSmile", {40, -10, 47}, {18, 16, 18}, {1, 4, 2.5f}},  // the cheek above
    {"mouthFrown", {27, -41, 53}, {15, 15, 18}, {1.5f, -5.5f, -1}},
    {"mouthDimple", {27, -41, 53}, {14, 15, 18}, {2.5f, 3, -6}},
    {"mouthStretch", {27, -42, 53}, {18, 20, 20}, {7, -3, -6}},
    {"mouthPress", {12, -47, 60}, {16, 9, 16}, {0, 2.5f, -1.5f}, Lip::kLower},
    {"mouthLowerDown", {12, -47, 61}, {13, 14, 16}, {1, -4.5f, 0.5f}, Lip::kLower},
    {"mouthUpperUp", {12, -36, 63}, {13, 13, 16}, {0.5f, 4, 0.5f}, Lip::kUpper},
    {"mouthUpperUp", {15, -12, 65}, {10, 10, 12}, {0.5f, 2.5f, 0}},  // wing of the nose
    {"browDown", {17, 53, 57}, {16, 16, 18}, {-3, -4, 1.5f}},
    {"browDown", {42, 55, 46}, {16, 16, 18}, {-1, -3, 0}},
    {"browOuterUp", {42, 57, 46}, {17, 18, 18}, {0, 8.5f, -1}},
    {"cheekSquint", {40, 3, 45}, {17, 14, 18}, {0, 5.5f, 1.5f}},
    {"noseSneer", {14, -11, 65}, {11, 13, 13}, {0.5f, 5.5f, 0}},
    {"noseSneer", {12, -35, 64}, {12, 11, 14}, {0, 3.5f, 0.5f}, Lip::kUpper},
    {"noseSneer", {12, 52, 60}, {11, 12, 14}, {0, -2.5f, 0.5f}}};  // inner brow

constexpr Move kSingle[] = {
    {"browInnerUp", {15, 56, 59}, {15, 17, 18}, {0, 6.5f, 0.5f}},
    {"cheekPuff", {42, -34, 38}, {19, 20, 22}, {11, 0, 6}},
    {"mouthRollLower", {0, -47, 62}, {24, 9, 16}, {0, 2, -6}, Lip::kLower},
    {"mouthRollUpper", {0, -36, 64}, {24, 8, 16}, {0, -2, -6}, Lip::kUpper},
    {"mouthShrugLower", {0, -66, 57}, {18, 14, 20}, {0, 7, 2}},  // the chin
    {"mouthShrugLower", {0, -47, 62}, {20, 9, 16}, {0, 4, 5}, Lip::kLower},
    {"mouthShrugUpper", {0, -35, 64}, {20, 11, 16}, {0, 5.5f, 3}, Lip::kUpper}};

// Degrees by which the lids turn, upwards.
struct LidMove {
  const char* name;
  float upper, lower;
};
constexpr LidMove kLids[] = {{"eyeSquint", -4, 7},
                             {"eyeWide", 10, -2},
                             {"eyeLookDown", -22, -6},
                             {"eyeLookUp", 10.5f, 4.5f}};

// Those of the head's own video.
struct Own {
  const char* name;
  Expression expression;
  float amount;
};
constexpr Own kOwn[] = {{"mouthFunnel", Expression::kFunnel, 1.8f},
                        {"mouthPucker", Expression::kPucker, 1.2f},
                        {"mouthLeft", Expression::kMouthShift, 2.2f},
                        {"mouthRight", Expression::kMouthShift, -2.2f},
                        {"eyeBlinkLeft", Expression::kBlinkLeft, 1},  // the lids come last
                        {"eyeBlinkRight", Expression::kBlinkRight, 1}};

constexpr float kOften = 0.003f;  // metres, of the vertex that a direction moves most

constexpr float kJawOpenRadians = 0.5f;           // of a score of 1, as GeneralBlendshapeMap has it
constexpr Vec kJawForward{0, -0.0017f, 0.0085f};  // metres

bool IsEye(const VertexLabel& label) {
  return label.part == Part::kLeftEye || label.part == Part::kRightEye;
}

float ShareOf(Lip lip, const Vec& p, const VertexLabel& label) {
  if (lip == Lip::kAny) return 1;
  const float side =
      label.mouth_ring != kNoRing ? label.upper : std::tanh((p.y - kMouthY) / 0.006f);
  return std::max(lip == Lip::kUpper ? side : -side, 0.0f);
}

// side: 1 left, -1 right, 0 both.
Vec ShiftBy(const Move& move, float side, const Vec& p, const VertexLabel& label) {
  if (IsEye(label)) return {};
  const float at = side == 0 ? std::abs(p.x) : side * p.x;
  const Vec q = (1000.0f * Vec{at, p.y, p.z} - move.at) / move.width;
  const float amount =
      0.001f * BellOfSquare(Dot(q, q), 1) * (1 - NearEye(p)) * ShareOf(move.lip, p, label);
  const float outwards = side == 0 ? std::tanh(p.x / 0.01f) : side;
  return amount * Vec{outwards * move.by.x, move.by.y, move.by.z};
}

// What takes a point of the lower lip, where the open jaw carries it, back: before skinning, so
// that with jaw's share w and rotation R about the joint w R (d + p) + (1 - w) (d + p) = p.
Vec CloseMouth(const Vec& p, const Vec& joint, float jaw_share) {
  const float reach = SmoothStep(-0.080f, -0.052f, p.y) * SmoothStep(0.005f, 0.035f, p.z);
  const Vec r = p - joint;
  const float c = jaw_share * (std::cos(kJawOpenRadians) - 1),
              s = jaw_share * std::sin(kJawOpenRadians);
  // (I + w (R - I)) d = -w (R - I) r, in the plane of y and z.
  const float y = -(c * r.y - s * r.z), z = -(s * r.y + c * r.z);
  const float determinant = (1 + c) * (1 + c) + s * s;
  return reach * Vec{0, ((1 + c) * y + s * z) / determinant, ((1 + c) * z - s * y) / determinant};
}

Vec PlaceOf(const FlameModel& model, size_t v) {
  const float* p = &model.template_vertices[3 * v];
  return {p[0], p[1], p[2]};
}
Vec JawOf(const FlameModel& model) {
  Vec joint{};
  const size_t count = size_t(model.vertex_count);
  for (size_t v = 0; v < count; ++v)
    joint = joint + model.joint_regressor[2 * count + v] * PlaceOf(model, v);
  return joint;
}

// Appends a direction; shift(v) is that of a vertex. The same name again adds to it.
template <class Shift>
void Add(const std::string& name, const Shift& shift, FlameModel& model) {
  const auto found = std::find(model.expression_names.begin(), model.expression_names.end(), name);
  const size_t size = 3 * size_t(model.vertex_count);
  const size_t at = size_t(found - model.expression_names.begin());
  if (found == model.expression_names.end()) {
    model.expression_names.push_back(name);
    model.expression_directions.resize(model.expression_directions.size() + size);
    ++model.expression_count;
  }
  for (size_t v = 0; v < size / 3; ++v) {
    const Vec d = shift(v);
    for (size_t k = 0; k < 3; ++k) model.expression_directions[at * size + 3 * v + k] += d[k];
  }
}

// Not the lids, whose coefficients are scores.
void ScaleToWhatFacesOftenDo(FlameModel& model) {
  const size_t size = 3 * size_t(model.vertex_count);
  model.expression_scores.assign(size_t(model.expression_count), 1);
  for (size_t e = 0; e + 2 < size_t(model.expression_count); ++e) {
    float* direction = &model.expression_directions[e * size];
    float most = 0;
    for (size_t i = 0; i < size; i += 3)
      most = std::max(most, Length(Vec{direction[i], direction[i + 1], direction[i + 2]}));
    model.expression_scores[e] = most / kOften;
    for (size_t i = 0; i < size; ++i) direction[i] *= kOften / most;
  }
}

}  // namespace

void SetArkitExpressions(const HeadMesh& mesh, FlameModel& model) {
  model.expression_count = 0;
  model.expression_directions.clear();
  model.expression_names.clear();
  const auto by = [&](const Move& move, float side) {
    return [&, side](size_t v) { return ShiftBy(move, side, mesh.positions[v], mesh.labels[v]); };
  };
  for (const Move& move : kPaired) {
    Add(std::string(move.name) + "Left", by(move, 1), model);
    Add(std::string(move.name) + "Right", by(move, -1), model);
  }
  for (const Move& move : kSingle) Add(move.name, by(move, 0), model);
  for (const LidMove& lids : kLids)
    for (const bool left : {true, false})
      Add(
          std::string(lids.name) + (left ? "Left" : "Right"),
          [&](size_t v) { return LidShift(mesh, int(v), left, lids.upper, lids.lower); },
          model);
  const auto jaw_share = [&](size_t v) { return model.skinning_weights[kFlameJoints * v + 2]; };
  Add(
      "jawForward", [&](size_t v) { return jaw_share(v) * kJawForward; }, model);
  const Vec jaw = JawOf(model);
  Add(
      "mouthClose",
      [&](size_t v) { return CloseMouth(PlaceOf(model, v), jaw, jaw_share(v)); },
      model);
  for (const Own& own : kOwn)
    Add(
        own.name,
        [&](size_t v) { return own.amount * ExpressionShift(mesh, int(own.expression), int(v)); },
        model);
  ScaleToWhatFacesOftenDo(model);
}

}  // namespace cosplat::procedural
