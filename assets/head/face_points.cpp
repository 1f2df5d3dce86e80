// MediaPipe's points on the head: where the detector sees them in the head's own video.
//
// Medians over 360 frames that `make-head --seed 5` films from all around the front, of the points
// of `cosplat landmarks` cast onto the posed mesh and brought to its rest; right and left averaged.
// Half of them scatter by less than 2.5 mm. Points of the lips' inner rim, which an open mouth
// shows against the teeth, are on the rim by their distance from its middle.

#include <algorithm>
#include <array>
#include <cmath>

#include "assets/head/rig.h"

namespace cosplat::procedural {
namespace {

struct SeenPoint {
  int right, left;  // landmarks; the same in the median plane
  Vec at;           // of the right one
};

// clang-format off
constexpr SeenPoint kFirm[] = {
    {0, 0, {0.0000f, -0.0343f, 0.0655f}},
    {4, 4, {0.0000f, -0.0056f, 0.0839f}},
    {5, 5, {0.0000f, 0.0038f, 0.0764f}},
    {6, 6, {0.0000f, 0.0263f, 0.0665f}},
    {7, 249, {-0.0422f, 0.0298f, 0.0493f}},
    {17, 17, {0.0000f, -0.0516f, 0.0611f}},
    {33, 263, {-0.0449f, 0.0318f, 0.0478f}},
    {37, 267, {-0.0078f, -0.0329f, 0.0654f}},
    {39, 269, {-0.0151f, -0.0349f, 0.0642f}},
    {40, 270, {-0.0197f, -0.0369f, 0.0618f}},
    {46, 276, {-0.0540f, 0.0487f, 0.0447f}},
    {52, 282, {-0.0392f, 0.0553f, 0.0562f}},
    {53, 283, {-0.0478f, 0.0534f, 0.0506f}},
    {55, 285, {-0.0131f, 0.0463f, 0.0632f}},
    {61, 291, {-0.0252f, -0.0403f, 0.0557f}},
    {63, 293, {-0.0513f, 0.0587f, 0.0472f}},
    {65, 295, {-0.0279f, 0.0536f, 0.0617f}},
    {66, 296, {-0.0287f, 0.0593f, 0.0619f}},
    {70, 300, {-0.0578f, 0.0526f, 0.0390f}},
    {84, 314, {-0.0080f, -0.0508f, 0.0613f}},
    {91, 321, {-0.0197f, -0.0452f, 0.0623f}},
    {97, 326, {-0.0075f, -0.0191f, 0.0669f}},
    {98, 327, {-0.0176f, -0.0167f, 0.0611f}},
    {105, 334, {-0.0414f, 0.0612f, 0.0545f}},
    {107, 336, {-0.0145f, 0.0547f, 0.0669f}},
    {129, 358, {-0.0207f, -0.0093f, 0.0604f}},
    {133, 362, {-0.0157f, 0.0289f, 0.0519f}},
    {144, 373, {-0.0364f, 0.0269f, 0.0532f}},
    {145, 374, {-0.0313f, 0.0260f, 0.0544f}},
    {146, 375, {-0.0230f, -0.0424f, 0.0597f}},
    {153, 380, {-0.0263f, 0.0267f, 0.0526f}},
    {154, 381, {-0.0213f, 0.0281f, 0.0491f}},
    {155, 382, {-0.0184f, 0.0285f, 0.0487f}},
    {157, 384, {-0.0220f, 0.0340f, 0.0509f}},
    {158, 385, {-0.0276f, 0.0358f, 0.0543f}},
    {159, 386, {-0.0327f, 0.0361f, 0.0549f}},
    {160, 387, {-0.0378f, 0.0353f, 0.0539f}},
    {161, 388, {-0.0412f, 0.0340f, 0.0517f}},
    {163, 390, {-0.0396f, 0.0283f, 0.0514f}},
    {168, 168, {0.0000f, 0.0345f, 0.0655f}},
    {173, 398, {-0.0183f, 0.0312f, 0.0483f}},
    {181, 405, {-0.0147f, -0.0485f, 0.0621f}},
    {185, 409, {-0.0230f, -0.0386f, 0.0591f}},
    {195, 195, {0.0000f, 0.0116f, 0.0713f}},
    {197, 197, {0.0000f, 0.0187f, 0.0684f}},
    {246, 466, {-0.0433f, 0.0329f, 0.0495f}},
    {468, 473, {-0.0318f, 0.0307f, 0.0544f}}
};
// Of cheeks, forehead and chin, and around lips and lids: they slide on the skin.
constexpr SeenPoint kSliding[] = {
    {10, 10, {0.0000f, 0.0880f, 0.0614f}},
    {11, 11, {0.0000f, -0.0368f, 0.0667f}},
    {12, 12, {0.0000f, -0.0390f, 0.0674f}},
    {22, 252, {-0.0254f, 0.0229f, 0.0543f}},
    {23, 253, {-0.0313f, 0.0223f, 0.0547f}},
    {24, 254, {-0.0371f, 0.0229f, 0.0539f}},
    {25, 255, {-0.0449f, 0.0275f, 0.0499f}},
    {26, 256, {-0.0204f, 0.0248f, 0.0527f}},
    {31, 261, {-0.0500f, 0.0238f, 0.0453f}},
    {38, 268, {-0.0069f, -0.0388f, 0.0665f}},
    {41, 271, {-0.0127f, -0.0390f, 0.0653f}},
    {47, 277, {-0.0180f, 0.0120f, 0.0598f}},
    {67, 297, {-0.0356f, 0.0866f, 0.0508f}},
    {72, 302, {-0.0075f, -0.0361f, 0.0670f}},
    {73, 303, {-0.0139f, -0.0371f, 0.0657f}},
    {85, 315, {-0.0077f, -0.0466f, 0.0660f}},
    {86, 316, {-0.0072f, -0.0431f, 0.0659f}},
    {89, 319, {-0.0176f, -0.0413f, 0.0626f}},
    {90, 320, {-0.0188f, -0.0429f, 0.0633f}},
    {96, 325, {-0.0208f, -0.0409f, 0.0578f}},
    {100, 329, {-0.0244f, 0.0081f, 0.0589f}},
    {101, 330, {-0.0343f, 0.0034f, 0.0578f}},
    {103, 332, {-0.0513f, 0.0817f, 0.0386f}},
    {106, 335, {-0.0224f, -0.0510f, 0.0587f}},
    {109, 338, {-0.0193f, 0.0883f, 0.0582f}},
    {110, 339, {-0.0420f, 0.0246f, 0.0519f}},
    {112, 341, {-0.0170f, 0.0266f, 0.0521f}},
    {113, 342, {-0.0510f, 0.0386f, 0.0441f}},
    {114, 343, {-0.0138f, 0.0162f, 0.0612f}},
    {117, 346, {-0.0524f, 0.0140f, 0.0468f}},
    {118, 347, {-0.0446f, 0.0109f, 0.0523f}},
    {119, 348, {-0.0330f, 0.0117f, 0.0557f}},
    {120, 349, {-0.0248f, 0.0143f, 0.0565f}},
    {121, 350, {-0.0186f, 0.0172f, 0.0571f}},
    {126, 355, {-0.0174f, 0.0050f, 0.0608f}},
    {130, 359, {-0.0475f, 0.0322f, 0.0471f}},
    {142, 371, {-0.0227f, -0.0001f, 0.0601f}},
    {148, 377, {-0.0113f, -0.0817f, 0.0543f}},
    {152, 152, {0.0000f, -0.0835f, 0.0518f}},
    {164, 164, {0.0000f, -0.0249f, 0.0660f}},
    {167, 393, {-0.0086f, -0.0252f, 0.0650f}},
    {179, 403, {-0.0131f, -0.0421f, 0.0649f}},
    {180, 404, {-0.0141f, -0.0447f, 0.0655f}},
    {182, 406, {-0.0162f, -0.0552f, 0.0596f}},
    {194, 418, {-0.0190f, -0.0605f, 0.0592f}},
    {204, 424, {-0.0262f, -0.0556f, 0.0562f}},
    {207, 427, {-0.0447f, -0.0239f, 0.0520f}},
    {226, 446, {-0.0515f, 0.0313f, 0.0425f}},
    {228, 448, {-0.0467f, 0.0204f, 0.0484f}},
    {229, 449, {-0.0405f, 0.0181f, 0.0519f}},
    {230, 450, {-0.0324f, 0.0177f, 0.0540f}},
    {231, 451, {-0.0250f, 0.0191f, 0.0547f}},
    {232, 452, {-0.0192f, 0.0213f, 0.0545f}},
    {233, 453, {-0.0151f, 0.0234f, 0.0550f}}
};
// On the inner rims of the lips.
struct RimPoint {
  int right, left;
  float x;  // of the left one
};
constexpr RimPoint kUpperRim[] = {{13, 13, 0.0f}, {82, 312, 0.0063f}, {81, 311, 0.0115f},
                                  {80, 310, 0.0162f}, {191, 415, 0.0197f}, {78, 308, 0.0229f}};
constexpr RimPoint kLowerRim[] = {{14, 14, 0.0f}, {87, 317, 0.0067f}, {178, 402, 0.0120f},
                                  {88, 318, 0.0166f}, {95, 324, 0.0198f}};
// clang-format on
constexpr int kRightIris = 468, kLeftIris = 473;
// Of a sliding point, in units of a firm one's.
constexpr double kSlidingLooseness = 1.5;

Vec Mirrored(const Vec& p) { return {-p.x, p.y, p.z}; }

class PointPlacer {
 public:
  explicit PointPlacer(const HeadMesh& mesh) : mesh_(mesh) {}

  // On the skin, or on an eyeball, as close to `at` as it can be.
  void Add(int landmark, const Vec& at, double looseness) {
    EmbeddedLandmark best;
    float least = HUGE_VALF;
    for (const std::array<int32_t, 3>& face : mesh_.faces) {
      if (!MayShow(landmark, mesh_.labels[size_t(face[0])].part)) continue;
      const std::array<float, 3> weights = Nearest(face, at);
      Vec on{};
      for (size_t k = 0; k < 3; ++k) on += weights[k] * mesh_.positions[size_t(face[k])];
      if (Length(on - at) >= least) continue;
      least = Length(on - at);
      best = {landmark, face, {weights[0], weights[1], weights[2]}, looseness};
    }
    points.push_back(best);
  }

  // On the rim that faces the other lip.
  void AddOnRim(int landmark, float x, float upper) {
    int best = mesh_.lip_loop.front();
    for (int v : mesh_.lip_loop)
      if (mesh_.labels[size_t(v)].upper * upper >= 0 &&
          std::abs(mesh_.positions[size_t(v)].x - x) <
              std::abs(mesh_.positions[size_t(best)].x - x))
        best = v;
    points.push_back({landmark, {best, best, best}, {1, 0, 0}, 1});
  }

  LandmarkEmbedding points;

 private:
  static bool MayShow(int landmark, Part part) {
    if (landmark == kLeftIris) return part == Part::kLeftEye;
    if (landmark == kRightIris) return part == Part::kRightEye;
    return part == Part::kSkin;
  }

  // Barycentric weights of the projection onto the triangle's plane, moved into the triangle.
  std::array<float, 3> Nearest(const std::array<int32_t, 3>& face, const Vec& at) const {
    const Vec& a = mesh_.positions[size_t(face[0])];
    const Vec u = mesh_.positions[size_t(face[1])] - a, v = mesh_.positions[size_t(face[2])] - a;
    const Vec d = at - a;
    const float uu = Dot(u, u), uv = Dot(u, v), vv = Dot(v, v);
    const float du = Dot(d, u), dv = Dot(d, v), area = std::max(uu * vv - uv * uv, 1e-20f);
    std::array<float, 3> w{0, (vv * du - uv * dv) / area, (uu * dv - uv * du) / area};
    w[0] = 1 - w[1] - w[2];
    float sum = 0;
    for (float& x : w) sum += x = std::max(x, 0.0f);
    for (float& x : w) x /= sum;
    return w;
  }

  const HeadMesh& mesh_;
};

}  // namespace

LandmarkEmbedding FacePoints(const HeadMesh& mesh) {
  PointPlacer placer(mesh);
  const auto add = [&](const SeenPoint& point, double looseness) {
    placer.Add(point.right, point.at, looseness);
    if (point.left != point.right) placer.Add(point.left, Mirrored(point.at), looseness);
  };
  for (const SeenPoint& point : kFirm) add(point, 1);
  for (const SeenPoint& point : kSliding) add(point, kSlidingLooseness);
  const auto add_rim = [&](const RimPoint& point, float upper) {
    placer.AddOnRim(point.left, point.x, upper);
    if (point.left != point.right) placer.AddOnRim(point.right, -point.x, upper);
  };
  for (const RimPoint& point : kUpperRim) add_rim(point, 1);
  for (const RimPoint& point : kLowerRim) add_rim(point, -1);
  return std::move(placer.points);
}

}  // namespace cosplat::procedural
