// Directions for fitting the head to people: each region of the face outwards, up and forward.
//
// The head's named directions are those of its own video. People differ, and move, in more ways:
// smooth bells of a few centimetres for the shape, of a lip's size for the expression.

#include <algorithm>
#include <array>

#include "assets/head/procedural_head.h"
#include "assets/head/rig.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

constexpr float kAmount = 0.0025f;  // metres at the middle of a region, coefficient 1

struct Region {
  Vec at;       // of the left side; x = 0 in the median plane
  float width;  // metres, of the bell
};
// `turned`: the two sides differ, as no symmetric direction can have it.
struct ShapeRegion {
  Region region;
  std::array<bool, 3> axes{true, true, true};
  bool turned = false;
};
constexpr ShapeRegion kShapeRegions[] = {
    {{{0, 0.145f, -0.030f}, 0.030f}},                                  // crown
    {{{0, 0.090f, 0.050f}, 0.030f}},                                   // forehead
    {{{0.045f, 0.075f, 0.030f}, 0.030f}},                              // its sides
    {{{0.070f, 0.030f, -0.030f}, 0.030f}},                             // temple and ear
    {{{0, 0.030f, -0.120f}, 0.030f}},                                  // back of the head
    {{{0.030f, 0.050f, 0.050f}, 0.030f}},                              // brow
    {{{0.032f, 0.030f, 0.050f}, 0.030f}},                              // eye
    {{{0.055f, 0.020f, 0.020f}, 0.030f}},                              // cheek bone
    {{{0.040f, 0, 0.045f}, 0.030f}},                                   // cheek
    {{{0, 0.030f, 0.060f}, 0.030f}},                                   // bridge of the nose
    {{{0, -0.005f, 0.075f}, 0.018f}},                                  // its tip
    {{{0.015f, -0.012f, 0.065f}, 0.018f}},                             // its wings
    {{{0, -0.025f, 0.065f}, 0.018f}},                                  // philtrum
    {{{0.025f, -0.042f, 0.055f}, 0.030f}},                             // corner of the mouth
    {{{0, -0.055f, 0.060f}, 0.030f}},                                  // below the lips
    {{{0, -0.075f, 0.050f}, 0.030f}},                                  // chin
    {{{0.045f, -0.045f, 0.020f}, 0.030f}},                             // jaw
    {{{0.060f, -0.020f, -0.010f}, 0.030f}},                            // its angle
    {{{0, -0.110f, 0}, 0.030f}},                                       // throat
    {{{0.018f, -0.020f, 0.058f}, 0.013f}, {true, true, true}},         // foot of the nose's wing
    {{{0.010f, -0.036f, 0.063f}, 0.013f}, {false, true, true}},        // upper lip
    {{{0.010f, -0.048f, 0.061f}, 0.013f}, {false, true, true}},        // lower lip
    {{{0.022f, -0.070f, 0.045f}, 0.020f}, {true, true, true}},         // side of the chin
    {{{0.045f, -0.028f, 0.030f}, 0.020f}, {true, false, true}},        // hollow of the cheek
    {{{0.030f, -0.024f, 0.052f}, 0.016f}, {true, false, true}},        // fold beside the mouth
    {{{0.015f, 0.052f, 0.060f}, 0.015f}, {false, true, true}},         // inner brow
    {{{0, -0.005f, 0.075f}, 0.025f}, {true, false, false}, true},      // tip of the nose
    {{{0, -0.075f, 0.050f}, 0.035f}, {true, false, false}, true},      // chin
    {{{0.045f, -0.045f, 0.020f}, 0.035f}, {true, true, false}, true},  // jaw
    {{{0.025f, -0.042f, 0.055f}, 0.025f}, {false, true, true}, true},  // corner of the mouth
    {{{0.030f, 0.050f, 0.050f}, 0.025f}, {false, true, true}, true},   // brow
    {{{0.032f, 0.030f, 0.050f}, 0.025f}, {false, true, false}, true},  // eye
    {{{0.045f, 0.005f, 0.040f}, 0.030f}, {false, false, true}, true},  // cheek
    {{{0.060f, 0.030f, 0.010f}, 0.040f}, {true, false, true}, true}};  // temple

// Which side of the lips' line moves.
enum class Lip { kBoth, kUpper, kLower };
struct MovingRegion {
  Region region;
  Lip lip;
};
// The left sides and, after each, the right one.
constexpr MovingRegion kMovingRegions[] = {
    {{{0, -0.036f, 0.065f}, 0.012f}, Lip::kUpper},
    {{{0.013f, -0.037f, 0.063f}, 0.010f}, Lip::kUpper},
    {{{0, -0.047f, 0.063f}, 0.012f}, Lip::kLower},
    {{{0.013f, -0.046f, 0.060f}, 0.010f}, Lip::kLower},
    {{{0, -0.065f, 0.060f}, 0.016f}, Lip::kLower},      // chin
    {{{0.026f, -0.041f, 0.053f}, 0.013f}, Lip::kBoth},  // corner of the mouth
    {{{0.040f, -0.015f, 0.045f}, 0.018f}, Lip::kBoth},  // cheek
    {{{0.014f, 0.055f, 0.055f}, 0.014f}, Lip::kBoth},   // inner brow
    {{{0.040f, 0.055f, 0.045f}, 0.016f}, Lip::kBoth}};  // outer brow

Vec Along(int axis, float amount) {
  Vec d{};
  d[axis] = amount;
  return d;
}

Vec ShapeShift(const Region& region, int axis, bool turned, const Vec& p) {
  const float amount = kAmount * Ball({std::abs(p.x), p.y, p.z}, region.at, region.width);
  // Outwards, or turned, with no jump between the sides.
  return Along(axis, (axis == 0) != turned ? amount * std::tanh(p.x / 0.01f) : amount);
}

// Share of the jaw in what moves with the head.
float JawShareOf(const float* weights) {
  return weights[2] / std::max(weights[1] + weights[2], 1e-6f);
}

float ShareOfLip(Lip lip, const float* weights) {
  if (lip == Lip::kBoth) return 1;
  const float jaw = JawShareOf(weights);
  return lip == Lip::kLower ? jaw : 1 - jaw;
}

void AddShape(const HeadMesh& mesh, const ShapeRegion& shape, FlameModel& model) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!shape.axes[size_t(axis)]) continue;
    ++model.shape_count;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto shift = [&](const Vec& p) {
        return ShapeShift(shape.region, axis, shape.turned, p);
      };
      const Vec d = RigidAtEyes(shift, mesh.positions[v], mesh.labels[v].part);
      model.shape_directions.insert(model.shape_directions.end(), {d.x, d.y, d.z});
    }
  }
}

void AddExpression(const HeadMesh& mesh,
                   const MovingRegion& moving,
                   float side,
                   const FlameModel& model,
                   std::vector<float>& directions) {
  const auto& [region, lip] = moving;
  const Vec at{side * region.at.x, region.at.y, region.at.z};
  for (int axis = 0; axis < 3; ++axis)
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const Part part = mesh.labels[v].part;
      const bool eye = part == Part::kLeftEye || part == Part::kRightEye;
      const float share = ShareOfLip(lip, &model.skinning_weights[kFlameJoints * v]);
      const Vec d =
          Along(axis, eye ? 0 : kAmount * share * Ball(mesh.positions[v], at, region.width));
      directions.insert(directions.end(), {d.x, d.y, d.z});
    }
}

}  // namespace

void AddRegionalDirections(const HeadMesh& mesh, FlameModel& model) {
  for (const ShapeRegion& shape : kShapeRegions) AddShape(mesh, shape, model);
  std::vector<float> directions;
  for (const MovingRegion& moving : kMovingRegions)
    for (const float side : {1.0f, -1.0f})
      if (side > 0 || moving.region.at.x > 0) AddExpression(mesh, moving, side, model, directions);
  const size_t count = directions.size() / (3 * mesh.positions.size());
  model.expression_count += int(count);
  model.expression_directions.insert(
      model.expression_directions.begin(), directions.begin(), directions.end());
  model.expression_names.insert(model.expression_names.begin(), count, "");
  model.expression_scores.insert(model.expression_scores.begin(), count, 0);
}

}  // namespace cosplat::procedural
