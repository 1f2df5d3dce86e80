// From the head of the demonstration video to the mean of people.
//
// Where our sculpture's face differs from the mean face of FLAME 2023 Open (CC-BY-4.0, Max Planck
// Institute for Intelligent Systems), region by region: least squares as `cosplat-study head-fit`
// has them, rounded to a tenth of a millimetre. Eyeballs get the radius that people's have.

#include <cmath>

#include "assets/head/rig.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

constexpr float kEyeRadiusOfPeople = 0.01204f;  // metres

// A bell of the left side or the median plane, millimetres.
struct Shift {
  Vec at;
  float width;
  Vec by;  // outwards, up, forward
};

// clang-format off
constexpr Shift kShifts[] = {
    {{0, 90, 50}, 30, {0, -0.9f, -2.1f}},
    {{45, 75, 30}, 30, {-0.6f, -1, -0.9f}},
    {{70, 30, -30}, 30, {0.3f, 0, 0}},
    {{30, 50, 50}, 30, {0.4f, -1.7f, -0.1f}},
    {{32, 30, 50}, 30, {0.9f, -0.1f, 0.6f}},
    {{55, 20, 20}, 30, {0, 2.3f, 0.5f}},
    {{40, 0, 45}, 30, {-1.2f, 2.5f, -0.9f}},
    {{0, 30, 60}, 30, {0, -0.8f, 0.8f}},
    {{0, -5, 75}, 18, {0, 2.9f, -3.4f}},
    {{15, -12, 65}, 18, {2.9f, 5.2f, -7.2f}},
    {{0, -25, 65}, 18, {0, -5, 7.9f}},
    {{25, -42, 55}, 30, {0.4f, 0.5f, -2.2f}},
    {{0, -55, 60}, 30, {0, 2.9f, 1.1f}},
    {{0, -75, 50}, 30, {0, -1.2f, 3.9f}},
    {{45, -45, 20}, 30, {3.8f, -1.4f, 3.1f}},
    {{60, -20, -10}, 30, {3, -0.1f, 0.6f}},
    {{0, -110, 0}, 30, {0, -0.6f, 0.1f}},
    {{54, 49, 45}, 20, {-0.7f, -4.7f, 2.3f}},
    {{39, 55, 56}, 20, {0.4f, -2.1f, 0.8f}},
    {{13, 46, 63}, 20, {-2, -2.7f, -2.8f}},
    {{0, 35, 66}, 20, {0, 2.7f, 0.1f}},
    {{0, 12, 72}, 20, {0, -1.6f, 12.2f}},
    {{0, -6, 85}, 20, {0, 0.9f, 3.8f}},
    {{21, -9, 60}, 20, {-2.4f, -4.9f, -0.3f}},
    {{8, -19, 67}, 20, {1.5f, 5.7f, 2.8f}},
    {{0, -34, 65}, 20, {0, 1.3f, 0.4f}},
    {{0, -52, 61}, 20, {0, 4.1f, 5.5f}},
    {{20, -37, 62}, 20, {0.8f, 0.6f, -4.7f}},
    {{0, 100, 54}, 20, {0, -0.2f, -0.5f}},
    {{12, 110, 47}, 20, {0.1f, 0.1f, 0.2f}},
    {{30, 109, 38}, 20, {0.1f, 0.1f, 0.2f}},
    {{46, 98, 34}, 20, {0.4f, 0.1f, 0.3f}},
    {{0, 77, 66}, 20, {0, -0.9f, -2.6f}},
    {{14, 88, 60}, 20, {-0.4f, -0.7f, -1.6f}},
    {{29, 90, 53}, 20, {-0.8f, -0.6f, -1.5f}},
    {{44, 79, 48}, 20, {-0.2f, -0.6f, -1.7f}},
    {{59, 75, 31}, 20, {-0.7f, 0.1f, -0.8f}},
    {{0, 56, 68}, 20, {0, -2.4f, -0.7f}},
    {{21, 65, 65}, 20, {-0.5f, 0.2f, -0.1f}},
    {{52, 65, 45}, 20, {-1.4f, -1.6f, -1.5f}},
    {{64, 54, 25}, 20, {-2.4f, -1.2f, -1.7f}},
    {{60, 37, 31}, 20, {0.7f, -2.3f, 1.4f}},
    {{65, 23, 24}, 20, {0, 0, -0.9f}},
    {{20, 9, 60}, 20, {-1.8f, -9.7f, 5.1f}},
    {{39, 7, 56}, 20, {0.2f, 1.7f, -3.4f}},
    {{57, 12, 44}, 20, {-6.1f, 3.7f, -3.8f}},
    {{9, -2, 71}, 20, {-1.7f, 3.1f, -0.9f}},
    {{68, 4, 27}, 20, {-2.3f, 1.3f, -0.6f}},
    {{49, -7, 52}, 20, {2.9f, 4.3f, -1.1f}},
    {{62, -10, 32}, 20, {0.9f, 2.1f, 2.7f}},
    {{29, -23, 58}, 20, {0.5f, -3.1f, 9.3f}},
    {{47, -27, 50}, 20, {-3.3f, 0.8f, -3}},
    {{59, -21, 20}, 20, {1.5f, 0.2f, 0.7f}},
    {{54, -29, 35}, 20, {-0.3f, 0.5f, 0.4f}},
    {{35, -39, 51}, 20, {1.9f, 2.8f, 1.6f}},
    {{46, -46, 38}, 20, {-1.3f, -0.2f, 4.3f}},
    {{31, -59, 52}, 20, {0, -1.7f, -1.9f}},
    {{0, -73, 61}, 20, {0, -0.4f, 5.5f}},
    {{19, -67, 60}, 20, {-3.4f, -1.9f, 5.1f}},
    {{41, -62, 37}, 20, {-0.6f, -0.7f, 2.1f}},
    {{29, -75, 46}, 20, {-0.1f, 0.5f, 1.7f}},
    {{0, -85, 49}, 20, {0, 0.1f, -1.8f}},
    {{36, -76, 28}, 20, {-0.1f, 0.4f, 0.3f}},
    {{15, -88, 39}, 20, {-1, 0.8f, -1.1f}},
    {{0, -88, 26}, 20, {0, -2.7f, 0.1f}},
    {{22, -85, 21}, 20, {-0.2f, -0.7f, 0}},
    {{12, 26, 58}, 20, {0.3f, -1.1f, -3.2f}},
    {{22, -40, 32}, 20, {3.1f, -0.1f, 1.9f}},
    {{13, -50, 43}, 20, {-0.8f, -2.5f, -1.9f}},
    {{13, -34, 46}, 20, {-1.9f, 0.6f, 2.5f}},
    {{0, -30, 36}, 20, {0, -0.5f, -0.1f}}};
// clang-format on

Vec FieldAt(const Vec& p) {
  Vec sum{};
  const Vec q = 1000.0f * Vec{std::abs(p.x), p.y, p.z};
  for (const Shift& shift : kShifts) sum = sum + 0.001f * Ball(q, shift.at, shift.width) * shift.by;
  return {sum.x * std::tanh(p.x / 0.01f), sum.y, sum.z};
}

}  // namespace

void ShiftToMeanOfPeople(const HeadMesh& mesh, FlameModel& model) {
  constexpr float kSmaller = kEyeRadiusOfPeople / kEyeRadius - 1;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec p = mesh.positions[v];
    const Vec d = kSmaller * NearEye(p) * (p - EyeCenter(p.x > 0)) +
                  RigidAtEyes(FieldAt, p, mesh.labels[v].part);
    for (size_t k = 0; k < 3; ++k) model.template_vertices[3 * v + k] += d[k];
  }
}

}  // namespace cosplat::procedural
