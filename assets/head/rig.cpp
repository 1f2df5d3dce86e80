#include "assets/head/rig.h"

#include <algorithm>
#include <cmath>

#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

constexpr Vec kRootJoint{0, -0.150f, -0.055f};
constexpr Vec kJawJoint{0, -0.004f, -0.022f};
constexpr int kSmoothing = 6;

// Share of a point's motion that follows the head rather than the shoulders.
float NeckShare(const NeckRig& neck, const Vec& p) {
  return SmoothStep(neck.from, neck.to, p.y + neck.slope * (p.z + 0.05f));
}

// Share of the jaw in the motion of the head's skin away from the lips, by the angle at the jaw
// joint.
float JawShare(const Vec& p) {
  const float below = std::atan2(kJawJoint.y - p.y, p.z - kJawJoint.z) * 57.29578f;
  const float width = 4 + 14 * SmoothStep(0.018f, 0.048f, std::abs(p.x));
  const float under = SmoothStep(24 - width, 24 + width, below);
  return under * SmoothStep(-0.032f, 0.030f, p.z) * SmoothStep(-0.128f, -0.088f, p.y);
}

// The same on a ring around the mouth.
float JawShareOfRing(const VertexLabel& l) {
  const float a = std::abs(l.along), a4 = a * a * a * a;
  if (l.mouth_ring >= kGum) {
    if (l.upper == 0) return 0.45f;
    if (l.mouth_ring == kThroat) return l.upper > 0 ? 0.0f : 0.6f;
    return l.upper > 0 ? 0.0f : 1.0f;
  }
  return l.upper > 0 ? 0.42f * a4 : l.upper < 0 ? 1 - 0.58f * a4 : 0.42f;
}

float InitialJawShare(const Vec& p, const VertexLabel& l) {
  if (l.part == Part::kLeftEye || l.part == Part::kRightEye || l.part == Part::kEar) return 0;
  if (l.mouth_ring == kNoRing) return JawShare(p);
  if (l.mouth_ring >= 0) return JawShareOfRing(l);
  return Mix(JawShareOfRing(l), JawShare(p), -0.25f * float(l.mouth_ring));
}

std::vector<float> SmoothedJawShares(const HeadMesh& mesh) {
  const size_t n = mesh.positions.size();
  std::vector<float> share(n), next;
  for (size_t v = 0; v < n; ++v) share[v] = InitialJawShare(mesh.positions[v], mesh.labels[v]);
  std::vector<float> sum(n), count(n);
  for (int i = 0; i < kSmoothing; ++i) {
    std::fill(sum.begin(), sum.end(), 0.0f);
    std::fill(count.begin(), count.end(), 0.0f);
    for (const auto& f : mesh.faces)
      for (int c = 0; c < 3; ++c) {
        sum[f[c]] += share[f[(c + 1) % 3]];
        count[f[c]] += 1;
      }
    for (size_t v = 0; v < n; ++v)
      if (mesh.labels[v].mouth_ring < 0 && mesh.labels[v].part == Part::kSkin)
        share[v] = 0.5f * share[v] + 0.5f * sum[v] / count[v];
  }
  return share;
}

// Vertices whose mean, after a correction to match the joint exactly, regresses it.
bool Supports(int joint, const Vec& at, const Vec& p, Part part) {
  const Vec d = p - at;
  switch (joint) {
    case 0:
      return part == Part::kSkin && p.y < -0.128f;
    case 1:
      return part == Part::kSkin && std::abs(d.y) < 0.022f && p.z < 0.015f;
    case 2:
      return part == Part::kSkin && std::abs(d.y) < 0.020f && std::abs(d.z) < 0.030f;
    case 3:
      return part == Part::kLeftEye;
    default:
      return part == Part::kRightEye;
  }
}

// Solves the symmetric 3x3 system m x = b by Cramer's rule.
std::array<double, 3> Solve(const double (&m)[3][3], const double (&b)[3]) {
  auto det = [](const double(&a)[3][3]) {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  };
  const double whole = det(m);
  std::array<double, 3> x;
  for (int k = 0; k < 3; ++k) {
    double c[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) c[i][j] = j == k ? b[i] : m[i][j];
    x[k] = det(c) / whole;
  }
  return x;
}

}  // namespace

std::array<Vec, kFlameJoints> JointPositions(const NeckRig& neck) {
  return {kRootJoint, neck.joint, kJawJoint, EyeCenter(true), EyeCenter(false)};
}

std::vector<float> SkinningWeights(const HeadMesh& mesh, const NeckRig& rig) {
  const auto jaw = SmoothedJawShares(mesh);
  std::vector<float> weights(mesh.positions.size() * kFlameJoints, 0.0f);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    float* w = &weights[v * kFlameJoints];
    const Part part = mesh.labels[v].part;
    if (part == Part::kLeftEye || part == Part::kRightEye) {
      w[part == Part::kLeftEye ? 3 : 4] = 1;
      continue;
    }
    const float neck = NeckShare(rig, mesh.positions[v]);
    w[2] = neck * jaw[v];
    w[1] = neck - w[2];
    w[0] = 1 - neck;
  }
  return weights;
}

std::vector<float> JointRegressor(const HeadMesh& mesh, const NeckRig& neck) {
  const size_t n = mesh.positions.size();
  std::vector<float> regressor(n * kFlameJoints, 0.0f);
  for (int j = 0; j < kFlameJoints; ++j) {
    const Vec target = JointPositions(neck)[size_t(j)];
    std::vector<size_t> support;
    double mean[3] = {0, 0, 0};
    for (size_t v = 0; v < n; ++v) {
      if (!Supports(j, target, mesh.positions[v], mesh.labels[v].part)) continue;
      support.push_back(v);
      for (int i = 0; i < 3; ++i) mean[i] += mesh.positions[v][i];
    }
    double off[3], covariance[3][3] = {};
    for (int i = 0; i < 3; ++i) {
      mean[i] /= double(support.size());
      off[i] = target[i] - mean[i];
    }
    for (size_t v : support)
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          covariance[a][b] += (mesh.positions[v][a] - mean[a]) * (mesh.positions[v][b] - mean[b]);
    // w_i = 1/n + mu (p_i - mean) sums to 1 and gives sum w_i p_i = mean + covariance mu.
    const auto mu = Solve(covariance, off);
    for (size_t v : support) {
      double w = 1.0 / double(support.size());
      for (int i = 0; i < 3; ++i) w += mu[i] * (mesh.positions[v][i] - mean[i]);
      regressor[size_t(j) * n + v] = float(w);
    }
  }
  return regressor;
}

float NearEye(const Vec& p) {
  const float left = Length(p - EyeCenter(true)), right = Length(p - EyeCenter(false));
  return 1 - SmoothStep(0.0185f, 0.030f, std::min(left, right));
}

}  // namespace cosplat::procedural
