// cosplat_make_village OUT PICTURES [HEIGHTS [PLACES]]: the made village seen from the first
// HEIGHTS (3) of 1, 5 and 25 metres, as a scene in Blender's layout: PICTURES training views per
// height, spread as a person with a camera and a drone would, and 8 test views per height, which do
// not depend on PICTURES; names begin with the height. Points are on the surfaces, with 2 cm of
// noise, as a reconstruction finds them. PLACES (1) such villages stand in a row, too far from each
// other to be seen, each with views of its own, whose names then begin with the place's number.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/rng.h"
#include "splat/io/ply.h"
#include "splat/media/image_io.h"
#include "tests/altitudes/village.h"

namespace cosplat {
namespace {

using procedural::Vec;

constexpr float kPi = 3.14159265f;
constexpr int kWidth = 400, kHeight = 300;  // px
constexpr int kTestViews = 8;               // per height
constexpr float kBetweenPlaces = 200;       // m, along x
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
  const Vec right = math::Normalize(math::Cross(forward, procedural::Vec{0, 0, 1}));
  const Vec up = math::Cross(right, forward);
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

struct Scene {
  Village village;
  Camera lens;
  std::string out;
  size_t heights = 3;
  int places = 1;

  // Of a place's files.
  std::string NamePrefix(int place) const {
    return places == 1 ? "" : std::to_string(place + 1) + "_";
  }
};

// Draws the views of a height and place, and adds them to `frames`.
void DrawViews(const Scene& scene,
               const std::string& split,
               const Height& height,
               int place,
               int views,
               uint64_t seed,
               Json& frames) {
  Rng rng{seed + 2 * uint64_t(place)};
  for (int i = 0; i < views; ++i) {
    auto matrix = PoseAt(height, (float(i) + 0.5f * float(seed % 2)) / float(views), rng);
    Camera camera = scene.lens;
    std::array<double, 12> pose;
    std::copy(matrix.begin(), matrix.begin() + 12, pose.begin());
    SetPoseFromOpenGlWorldFromCam(pose, camera);
    char number[8];
    std::snprintf(number, sizeof number, "_%03d", i);
    const std::string name = split + "/" + scene.NamePrefix(place) + height.name + number + ".png";
    WriteImage(scene.out + "/" + name, DrawVillage(scene.village, camera));
    matrix[3] += kBetweenPlaces * float(place);
    Json rows = Json::array();
    for (size_t r = 0; r < 4; ++r)
      rows.push_back({matrix[4 * r], matrix[4 * r + 1], matrix[4 * r + 2], matrix[4 * r + 3]});
    frames.push_back({{"file_path", name}, {"transform_matrix", rows}});
  }
}

void WriteViews(const Scene& scene, const std::string& split, int views, uint64_t seed) {
  Json frames = Json::array();
  for (int place = 0; place < scene.places; ++place)
    for (size_t h = 0; h < scene.heights; ++h)
      DrawViews(scene, split, kHeights[h], place, views, seed, frames);
  const Camera& lens = scene.lens;
  const Json file = {{"fl_x", lens.fx},
                     {"fl_y", lens.fy},
                     {"cx", lens.cx},
                     {"cy", lens.cy},
                     {"w", lens.width},
                     {"h", lens.height},
                     {"ply_file_path", "points.ply"},
                     {"frames", frames}};
  WriteFileAtomically(scene.out + "/transforms_" + split + ".json", file.dump(1) + "\n");
}

// Random points of random faces, of all places.
void WritePoints(const Scene& scene) {
  const Village& village = scene.village;
  Rng rng{3};
  std::vector<float> points;
  std::vector<uint8_t> colors;
  const size_t count = size_t(kPoints) * size_t(scene.places);
  while (points.size() < 3 * count) {
    const size_t place = points.size() / (3 * size_t(kPoints));
    const size_t face = rng.Below(village.faces.size());
    const float a = std::sqrt(rng.Uniform()), b = rng.Uniform();
    const std::array<float, 3> at{1 - a, a * (1 - b), a * b};
    std::array<float, 3> p{kBetweenPlaces * float(place), 0, 0};
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k)
        p[i] += at[k] * village.vertices[3 * size_t(village.faces[face][k]) + i];
    const auto rgb = PaintVillage(village, int(face), at, {0, 0, 10}, 0.005f);
    for (size_t i = 0; i < 3; ++i) {
      points.push_back(p[i] + kPointNoise * rng.Normal());
      colors.push_back(uint8_t(255 * rgb[i] + 0.5f));
    }
  }
  WritePointsPly(scene.out + "/points.ply", points, colors);
}

int Number(const char* text, const char* name, int max) {
  const int number = std::atoi(text);
  if (number < 1 || number > max)
    throw Error(name, std::string(text) + " is not from 1 to " + std::to_string(max));
  return number;
}

void Make(int argc, char** argv) {
  const int pictures = Number(argv[2], "PICTURES", 1000);
  Scene scene;
  scene.out = argv[1];
  if (argc > 3) scene.heights = size_t(Number(argv[3], "HEIGHTS", int(std::size(kHeights))));
  if (argc > 4) scene.places = Number(argv[4], "PLACES", 100);
  scene.village = MakeVillage();
  Camera& lens = scene.lens;
  lens.width = kWidth;
  lens.height = kHeight;
  lens.fx = lens.fy = 0.8f * float(kWidth);
  lens.cx = 0.5f * float(kWidth);
  lens.cy = 0.5f * float(kHeight);
  for (const char* split : {"train", "test"}) MakeDirectories(scene.out + "/" + split);
  WritePoints(scene);
  WriteViews(scene, "train", pictures, 1);
  WriteViews(scene, "test", kTestViews, 2);
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: cosplat_make_village OUT PICTURES [HEIGHTS [PLACES]]\n");
    return 2;
  }
  try {
    cosplat::Make(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
