// cosplat_make_village OUT PICTURES [WIDTH]: the made village seen from 1, 5 and 25 metres, as a
// scene in Blender's layout: PICTURES training views per height, spread as a person with a camera
// and a drone would, and 8 test views per height, which do not depend on PICTURES; names begin with
// the height. Points are on the surfaces, with 2 cm of noise, as a reconstruction finds them.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/image_io.h"
#include "splat/base/json.h"
#include "splat/base/rng.h"
#include "splat/io/ply.h"
#include "tests/altitudes/village.h"

namespace cosplat {
namespace {

using procedural::Vec;

constexpr float kPi = 3.14159265f;
constexpr int kTestViews = 8;  // per height
constexpr int kPoints = 6000;
constexpr float kPointNoise = 0.02f;  // m

struct Height {
  const char* name;
  float metres;
  float nearest, farthest;  // of the camera from the middle, m
  float look_down;          // radians below the horizon
  bool outwards;            // any direction, or towards the middle
};
constexpr Height kHeights[] = {{"01m", 1, 0.5f, 5.0f, 0.10f, true},
                               {"05m", 5, 0.5f, 5, 0.35f, true},
                               {"25m", 25, 12, 20, 1.0f, false}};

// World from camera with OpenGL's axes, row by row, as Blender's files have it.
std::array<float, 16> MatrixOf(const Vec& eye, float yaw, float look_down) {
  const Vec forward{std::cos(yaw) * std::cos(look_down),
                    std::sin(yaw) * std::cos(look_down),
                    -std::sin(look_down)};
  const Vec right = procedural::Normalized(procedural::Cross(forward, {0, 0, 1}));
  const Vec up = procedural::Cross(right, forward);
  std::array<float, 16> m{};
  for (int i = 0; i < 3; ++i) {
    m[size_t(4 * i)] = right[i], m[size_t(4 * i + 1)] = up[i];
    m[size_t(4 * i + 2)] = -forward[i], m[size_t(4 * i + 3)] = eye[i];
  }
  m[15] = 1;
  return m;
}

// The view `share` of the way around, with jitter.
std::array<float, 16> PoseAt(const Height& h, float share, Rng& rng) {
  const auto jitter = [&](float size) { return size * (2 * rng.Uniform() - 1); };
  const float turn = 2 * kPi * share;
  const float distance = h.nearest + (h.farthest - h.nearest) * rng.Uniform();
  // On the ground a place of its own for each direction.
  const float place = h.outwards ? 2 * kPi * rng.Uniform() : turn;
  const Vec eye{
      distance * std::cos(place), distance * std::sin(place), h.metres * (1 + jitter(0.1f))};
  const float yaw = h.outwards ? turn + jitter(0.2f) : turn + kPi + jitter(0.25f);
  return MatrixOf(eye, yaw, h.look_down + jitter(0.08f));
}

void WriteViews(const Village& village,
                const std::string& out,
                const std::string& split,
                int views,
                const Camera& lens,
                uint64_t seed) {
  Json frames = Json::array();
  for (const Height& height : kHeights) {
    Rng rng{seed};
    for (int i = 0; i < views; ++i) {
      const auto matrix = PoseAt(height, (float(i) + 0.5f * float(seed % 2)) / float(views), rng);
      Camera camera = lens;
      std::array<double, 12> pose;
      std::copy(matrix.begin(), matrix.begin() + 12, pose.begin());
      SetPoseFromOpenGlWorldFromCam(pose, camera);
      char name[40];
      std::snprintf(name, sizeof name, "%s/%s_%03d.png", split.c_str(), height.name, i);
      WriteImage(out + "/" + name, DrawVillage(village, camera));
      Json rows = Json::array();
      for (size_t r = 0; r < 4; ++r)
        rows.push_back({matrix[4 * r], matrix[4 * r + 1], matrix[4 * r + 2], matrix[4 * r + 3]});
      frames.push_back({{"file_path", name}, {"transform_matrix", rows}});
    }
  }
  const Json file = {{"fl_x", lens.fx},
                     {"fl_y", lens.fy},
                     {"cx", lens.cx},
                     {"cy", lens.cy},
                     {"w", lens.width},
                     {"h", lens.height},
                     {"ply_file_path", "points.ply"},
                     {"frames", frames}};
  WriteFileAtomically(out + "/transforms_" + split + ".json", file.dump(1) + "\n");
}

// Random points of random faces.
void WritePoints(const Village& village, const std::string& path) {
  Rng rng{3};
  std::vector<float> points;
  std::vector<uint8_t> colors;
  while (points.size() < 3 * size_t(kPoints)) {
    const size_t face = rng.Below(village.faces.size());
    const float a = std::sqrt(rng.Uniform()), b = rng.Uniform();
    const std::array<float, 3> at{1 - a, a * (1 - b), a * b};
    std::array<float, 3> p{};
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k)
        p[i] += at[k] * village.vertices[3 * size_t(village.faces[face][k]) + i];
    const auto rgb = PaintVillage(village, int(face), at, {0, 0, 10}, 0.005f);
    for (size_t i = 0; i < 3; ++i) {
      points.push_back(p[i] + kPointNoise * rng.Normal());
      colors.push_back(uint8_t(255 * rgb[i] + 0.5f));
    }
  }
  WritePointsPly(path, points, colors);
}

void Make(const std::string& out, int pictures, int width) {
  if (pictures < 1) throw Error("PICTURES", "is less than 1");
  if (width < 16) throw Error("WIDTH", "is less than 16");
  Camera lens;
  lens.width = width;
  lens.height = width * 3 / 4;
  lens.fx = lens.fy = 0.8f * float(width);
  lens.cx = 0.5f * float(lens.width);
  lens.cy = 0.5f * float(lens.height);
  const Village village = MakeVillage();
  for (const char* split : {"train", "test"}) MakeDirectories(out + "/" + split);
  WritePoints(village, out + "/points.ply");
  WriteViews(village, out, "train", pictures, lens, 1);
  WriteViews(village, out, "test", kTestViews, lens, 2);
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fprintf(stderr, "usage: cosplat_make_village OUT PICTURES [WIDTH]\n");
    return 2;
  }
  try {
    cosplat::Make(argv[1], std::atoi(argv[2]), argc == 4 ? std::atoi(argv[3]) : 400);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
