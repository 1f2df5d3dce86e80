// assets/head/procedural_head.h: the model's make-up, and that mouth, lids and eyes do what they
// should.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "assets/head/raster.h"
#include "assets/head/rig.h"
#include "assets/head/sculpt.h"
#include "flame/mouth.h"
#include "flame/pose.h"
#include "flame/topology.h"

namespace cosplat::test {
namespace {

using procedural::kNoRing;
using procedural::Part;
using procedural::Vec;

const ProceduralHead& Head() {
  static const ProceduralHead head = MakeProceduralHeadParts();
  return head;
}

bool IsEye(Part part) { return part == Part::kLeftEye || part == Part::kRightEye; }

using Frame = FlamePoser<float>::Parameters;

Frame RestFrame() {
  Frame frame;
  frame.expression.assign(kExpressionCount, 0.0f);
  return frame;
}
std::vector<float> Posed(const Frame& frame) {
  const FlamePoser<float> poser(Head().model, {});
  std::vector<float> vertices;
  poser.Forward(frame, vertices);
  return vertices;
}
Vec At(const std::vector<float>& vertices, int v) {
  return {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
}

// Red: eyeballs; green: the inside of the mouth and back faces.
class Regions : public procedural::Shader {
 public:
  std::array<float, 3> Shade(const procedural::SurfacePoint& p) const override {
    const auto& face = Head().mesh.faces[p.face];
    bool mouth = p.back;
    for (int v : face) mouth = mouth || Head().mesh.labels[v].part == Part::kMouth;
    return {IsEye(Head().mesh.labels[face[0]].part) ? 1.0f : 0.0f, mouth ? 1.0f : 0.0f, 0};
  }
};

struct Seen {
  double eyes = 0, mouth = 0;  // px
};
Seen CountSeen(const Frame& frame, float azimuth = 0) {
  const Camera camera = procedural::OrbitCamera(azimuth, 0, 0.9f, 256);
  const Image8 image = procedural::Rasterize(Posed(frame), Head().model.faces, camera, Regions());
  Seen seen;
  for (size_t i = 0; i < image.data.size(); i += 4) {
    if (image.data[i + 3] == 0) continue;
    seen.eyes += image.data[i] / 255.0;
    seen.mouth += image.data[i + 1] / 255.0;
  }
  return seen;
}

TEST(ProceduralHead, IsAValidModelOfFlamesMakeUp) {
  const FlameModel& m = Head().model;
  EXPECT_NO_THROW(Validate(m));
  EXPECT_GT(m.vertex_count, 4500);
  EXPECT_LT(m.vertex_count, 5500);
  EXPECT_GE(m.shape_count, 10);
  EXPECT_GE(m.expression_count, 12);
  EXPECT_TRUE(m.redistributable);
  float low[3] = {1, 1, 1}, high[3] = {-1, -1, -1};
  for (int v = 0; v < m.vertex_count; ++v)
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], m.template_vertices[3 * v + i]);
      high[i] = std::max(high[i], m.template_vertices[3 * v + i]);
    }
  EXPECT_NEAR(high[1] - low[1], 0.32, 0.03);  // with neck, hair and the start of the shoulders
  EXPECT_NEAR(high[0] - low[0], 0.24, 0.05);
  EXPECT_NEAR(high[0] + low[0], 0, 1e-4);
}

TEST(ProceduralHead, IsTheSameEveryTime) {
  const FlameModel a = MakeProceduralHead();
  EXPECT_EQ(a.template_vertices, Head().model.template_vertices);
  EXPECT_EQ(a.faces, Head().model.faces);
  EXPECT_EQ(a.expression_directions, Head().model.expression_directions);
  EXPECT_EQ(a.skinning_weights, Head().model.skinning_weights);
}

TEST(ProceduralHead, HasThreeComponentsAndTwoBoundaries) {
  const FlameModel& m = Head().model;
  const MeshTopology t = BuildTopology(m.name, m.faces, m.vertex_count);
  EXPECT_EQ(t.component_count, 3);
  ASSERT_EQ(t.boundary_loops.size(), 2u);
  auto members = [](const auto& loop) { return std::set<int>(loop.begin(), loop.end()); };
  const std::set<std::set<int>> expected{members(Head().mesh.neck_loop),
                                         members(Head().mesh.throat_loop)};
  EXPECT_EQ(expected,
            (std::set<std::set<int>>{members(t.boundary_loops[0]), members(t.boundary_loops[1])}));
  // Euler characteristic: a sphere with two holes, and two spheres.
  std::map<int, std::set<int>> vertices;
  std::map<int, int> faces, boundary;
  for (size_t f = 0; f < m.faces.size(); ++f) {
    const int c = t.face_component[f];
    ++faces[c];
    for (int i = 0; i < 3; ++i) {
      vertices[c].insert(m.faces[f][i]);
      boundary[c] += t.face_neighbors[f][i] < 0;
    }
  }
  for (const auto& [c, count] : faces) {
    const int edges = (3 * count + boundary[c]) / 2;
    const bool eye = IsEye(Head().mesh.labels[*vertices[c].begin()].part);
    EXPECT_EQ(int(vertices[c].size()) - edges + count, eye ? 2 : 0);
  }
  size_t used = 0;
  for (const auto& [c, v] : vertices) used += v.size();
  EXPECT_EQ(used, size_t(m.vertex_count)) << "a vertex without faces";
}

TEST(ProceduralHead, FacesAreSoundAndLookOutwards) {
  const auto& mesh = Head().mesh;
  for (const auto& f : mesh.faces) {
    const Vec a = mesh.positions[f[0]], b = mesh.positions[f[1]], c = mesh.positions[f[2]];
    const Vec area = Cross(b - a, c - a);
    EXPECT_GT(0.5f * Length(area), 3e-9f) << f[0];
    const Part part = mesh.labels[f[0]].part;
    const Vec middle = (a + b + c) * (1 / 3.0f);
    if (IsEye(part)) {
      EXPECT_GT(Dot(area, middle - procedural::EyeCenter(part == Part::kLeftEye)), 0);
    }
    bool plain = true;  // on the sculpted solid itself
    for (int v : f)
      plain = plain && mesh.labels[v].part == Part::kSkin && mesh.labels[v].lid_ring == kNoRing &&
              mesh.labels[v].mouth_ring == kNoRing;
    if (plain) {
      EXPECT_GT(Dot(Normalize(area), Normalize(procedural::HeadGradient(middle))), 0.2f) << f[0];
      // Faces are flat and up to 12 mm wide under the hair.
      EXPECT_LT(std::abs(procedural::HeadDistance(middle)), 0.0045f) << f[0];
    }
  }
}

TEST(ProceduralHead, WeightsAreSharesAndJointsSitWhereTheyShould) {
  const FlameModel& m = Head().model;
  for (float w : m.skinning_weights) {
    EXPECT_GE(w, 0);
    EXPECT_LE(w, 1);
  }
  const auto joints = procedural::JointPositions(procedural::kFilmedNeck);
  for (int j = 0; j < kFlameJoints; ++j) {
    double at[3] = {0, 0, 0}, min = 1;
    for (int v = 0; v < m.vertex_count; ++v) {
      const double w = m.joint_regressor[size_t(j) * m.vertex_count + v];
      min = std::min(min, w);
      for (int i = 0; i < 3; ++i) at[i] += w * m.template_vertices[3 * v + i];
    }
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(at[i], joints[j][i], 1e-6) << j;
    EXPECT_GT(min, -0.05) << j;
  }
  EXPECT_NEAR(joints[3].x - joints[4].x, 0.064, 1e-6);
}

TEST(ProceduralHead, JawOpensTheMouth) {
  const auto& mesh = Head().mesh;
  const auto& lip = mesh.lip_loop;
  // A quarter of the way round lies the middle of the lower lip, three quarters that of the upper.
  const int lower = lip[lip.size() / 4], upper = lip[3 * lip.size() / 4];
  EXPECT_EQ(mesh.labels[lower].upper, -1);
  EXPECT_LT(Length(mesh.positions[upper] - mesh.positions[lower]), 0.001f);
  Frame frame = RestFrame();
  const double shut = CountSeen(frame).mouth;
  frame.pose[2][0] = 0.25f;
  const auto open = Posed(frame);
  EXPECT_GT(At(open, upper).y - At(open, lower).y, 0.013f);
  EXPECT_LT(Length(At(open, upper) - mesh.positions[upper]), 0.001f) << "the upper lip stays";
  EXPECT_GT(CountSeen(frame).mouth, shut + 200);
  EXPECT_LT(shut, 12) << "lips let the teeth shine through";
}

TEST(ProceduralHead, BlinkCoversTheEyes) {
  Frame frame = RestFrame();
  EXPECT_GT(CountSeen(frame).eyes, 150);
  frame.expression[int(Expression::kBlinkLeft)] = 1;
  const double one = CountSeen(frame).eyes;
  frame.expression[int(Expression::kBlinkRight)] = 1;
  for (float azimuth : {-0.6f, 0.0f, 0.6f}) EXPECT_EQ(CountSeen(frame, azimuth).eyes, 0) << azimuth;
  EXPECT_GT(one, 75);
  // Looking about under shut lids lifts nothing through them either.
  frame.pose[3] = frame.pose[4] = {0.14f, 0.26f, 0};
  EXPECT_EQ(CountSeen(frame).eyes, 0);
}

TEST(ProceduralHead, EyeballsStayInsideTheirLids) {
  const auto& mesh = Head().mesh;
  for (float pitch : {-0.14f, 0.0f, 0.14f})
    for (float blink : {0.0f, 0.5f, 1.0f}) {
      Frame frame = RestFrame();
      frame.pose[3][0] = frame.pose[4][0] = pitch;
      frame.expression[int(Expression::kBlinkLeft)] = blink;
      frame.expression[int(Expression::kBlinkRight)] = blink;
      const auto vertices = Posed(frame);
      for (size_t v = 0; v < mesh.labels.size(); ++v) {
        const auto& l = mesh.labels[v];
        if (l.lid_ring == kNoRing || l.lid_ring > 0) continue;
        const float radius =
            Length(At(vertices, int(v)) - procedural::EyeCenter(mesh.positions[v].x > 0));
        // Half-way through a blink the straight path of the inner edge cuts into its clearance.
        const float min = blink == 0.5f && l.lid_ring < 0 ? 0.0002f : 0.0006f;
        EXPECT_GT(radius, procedural::kEyeRadius + min) << v << " " << pitch << " " << blink;
      }
    }
}

TEST(ProceduralHead, EveryDirectionMovesSomethingAndNothingWildly) {
  const FlameModel& m = Head().model;
  auto largest = [&](const std::vector<float>& directions, int k) {
    float max = 0;
    for (int v = 0; v < m.vertex_count; ++v) {
      const float* d = &directions[(size_t(k) * m.vertex_count + v) * 3];
      max = std::max(max, std::hypot(d[0], d[1], d[2]));
    }
    return max;
  };
  for (int k = 0; k < m.shape_count; ++k) {
    EXPECT_GT(largest(m.shape_directions, k), 0.001f) << k;
    EXPECT_LT(largest(m.shape_directions, k), 0.010f) << k;
  }
  for (int k = 0; k < m.expression_count; ++k) {
    EXPECT_GT(largest(m.expression_directions, k), 0.001f) << k;
    EXPECT_LT(largest(m.expression_directions, k), 0.012f) << k;
  }
  for (int k = 0; k < kFlamePoseFeatures; ++k)
    EXPECT_LT(largest(m.pose_directions, k), 0.006f) << k;
}

TEST(ProceduralHead, ExpressionsLeaveEyeballsAlone) {
  const FlameModel& m = Head().model;
  for (int k = 0; k < m.expression_count; ++k)
    for (int v = 0; v < m.vertex_count; ++v)
      for (int i = 0; i < 3 && IsEye(Head().mesh.labels[v].part); ++i)
        EXPECT_EQ(m.expression_directions[(size_t(k) * m.vertex_count + v) * 3 + i], 0);
}

TEST(ProceduralHead, ShapesMoveLidsAndEyeballsTogether) {
  const FlameModel& m = Head().model;
  for (int s = 0; s < m.shape_count; ++s) {
    auto shift = [&](int v) {
      const float* d = &m.shape_directions[(size_t(s) * m.vertex_count + v) * 3];
      return Vec{d[0], d[1], d[2]};
    };
    int eyeball = 0;
    while (Head().mesh.labels[eyeball].part != Part::kLeftEye) ++eyeball;
    for (int v : Head().mesh.lid_loops[0]) EXPECT_LT(Length(shift(v) - shift(eyeball)), 1e-6f) << s;
  }
}

// What is added for fitting people moves a few millimetres, keeps eyeballs round, and leaves the
// head and its own directions as they are.
// What a collar covers stays at rest.
TEST(HeadForPeople, TurnsBetweenItsEars) {
  const FlameModel head = MakeHeadForPeople();
  const FlamePoser<float> poser(head, {});
  std::vector<float> rest, tilted;
  poser.Forward({}, rest);
  float joint = 0;  // height of the neck's, metres
  for (size_t v = 0; v < size_t(head.vertex_count); ++v)
    joint += head.joint_regressor[size_t(head.vertex_count) + v] * rest[3 * v + 1];
  EXPECT_NEAR(joint, -0.009f, 0.001f);
  FlamePoser<float>::Parameters parameters;
  constexpr float kTilt = 0.2f;  // radians
  parameters.pose[1] = {0, 0, kTilt};
  poser.Forward(parameters, tilted);
  for (size_t v = 0; v < size_t(head.vertex_count); ++v) {
    const float* const a = &rest[3 * v];
    const float* const b = &tilted[3 * v];
    if (a[1] < -0.145f) EXPECT_NEAR(a[0], b[0], 0.002f) << v;
    // Chin and crown are one rigid body.
    if (a[1] > 0.05f || (a[1] > -0.09f && a[2] > 0.04f))
      EXPECT_NEAR(std::hypot(b[0], b[1] - joint), std::hypot(a[0], a[1] - joint), 0.001f) << v;
  }
}

TEST(HeadForPeople, HasMoreDirectionsAndNoTeeth) {
  const FlameModel made = MakeProceduralHead(), head = MakeHeadForPeople();
  Validate(head);
  EXPECT_LT(head.vertex_count, made.vertex_count);
  EXPECT_GT(WithMouth(head).mouth.count(), 0) << "there is a hole for added ones";
  EXPECT_EQ(head.shape_count, made.shape_count + 85);
  constexpr size_t kRegional = 45;
  EXPECT_EQ(head.expression_count, int(kRegional) + 44);
  const size_t size = 3 * size_t(head.vertex_count);
  for (const std::vector<float>* directions :
       {&head.shape_directions, &head.expression_directions}) {
    const bool shape = directions == &head.shape_directions;
    const size_t first = shape ? size_t(made.shape_count) * size : 0;
    const size_t end = shape ? directions->size() : kRegional * size;
    for (size_t k = first; k < end; k += size) {
      float largest = 0;
      for (size_t i = k; i < k + size; ++i) largest = std::max(largest, std::abs((*directions)[i]));
      EXPECT_GT(largest, 0.0012f) << (k - first) / size;
      EXPECT_LT(largest, 0.0026f) << (k - first) / size;
      std::map<int, float> of_eye;  // one shift for each eyeball's vertices
      for (size_t v = 0; v < size_t(head.vertex_count); ++v)
        for (int eye = 3; eye < 5; ++eye)
          if (head.skinning_weights[kFlameJoints * v + size_t(eye)] == 1) {
            const float y = (*directions)[k + 3 * v + 1];
            EXPECT_NEAR(of_eye.emplace(eye, y).first->second, y, 1e-7);
          }
    }
  }
}

}  // namespace
}  // namespace cosplat::test
