// The table of engines in docs/plugin.md: what an engine's own camera sees at a pixel, the camera
// made by the table sees there.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <regex>
#include <sstream>
#include <string>

namespace {

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;  // rows

Vector operator*(const Matrix& m, const Vector& v) {
  Vector out{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) out[i] += m[i][k] * v[k];
  return out;
}
Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
  return out;
}
Vector operator+(const Vector& a, const Vector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Vector operator*(double s, const Vector& v) { return {s * v[0], s * v[1], s * v[2]}; }

double Determinant(const Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// Of an axis times an angle (Rodrigues), in any axes.
Matrix Turn(const Vector& w) {
  const double angle = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const Vector a = (1 / angle) * w;
  const double s = std::sin(angle), c = std::cos(angle), t = 1 - c;
  return {{{t * a[0] * a[0] + c, t * a[0] * a[1] - s * a[2], t * a[0] * a[2] + s * a[1]},
           {t * a[0] * a[1] + s * a[2], t * a[1] * a[1] + c, t * a[1] * a[2] - s * a[0]},
           {t * a[0] * a[2] - s * a[1], t * a[1] * a[2] + s * a[0], t * a[2] * a[2] + c}}};
}

// An engine, by its own documents.
struct Engine {
  Vector right, up, forward;  // of a character, in its world
  double unit;                // per metre
  // Rows: what is right, up and ahead in view space.
  Matrix view_axes;
  bool mirrored_view;  // view space has the other hand than the world
};

std::map<std::string, Engine> Engines() {
  const Matrix opengl = {{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}};
  const Matrix unreal = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
  return {{"OpenGL, glTF, Godot", {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, opengl, false}},
          {"Unity", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, opengl, true}},
          {"Unreal", {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, 100, unreal, false}}};
}

struct Row {
  Matrix engine_from_cosplat, opencv_from_view, turns;
};

Matrix ParseMatrix(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream numbers(text);
  Matrix m{};
  for (Vector& row : m)
    for (double& x : row) EXPECT_TRUE(numbers >> x) << text;
  return m;
}

std::map<std::string, Row> RowsOfThePage() {
  std::ifstream page(COSPLAT_SOURCE_DIR "/docs/plugin.md");
  static const std::regex pattern(
      R"(\| ([^|]+) \| [^|]+ \| `([^`]+)` \| `([^`]+)` \| `([^`]+)` \|)");
  std::map<std::string, Row> rows;
  for (std::string line; std::getline(page, line);) {
    std::smatch m;
    if (std::regex_match(line, m, pattern) && Engines().count(m[1]))
      rows[m[1]] = {ParseMatrix(m[2]), ParseMatrix(m[3]), ParseMatrix(m[4])};
  }
  return rows;
}

// Where a point of view space is in a picture: tangents to the right and downwards.
std::array<double, 2> Seen(const Engine& engine, const Vector& in_view) {
  const Vector v = engine.view_axes * in_view;
  return {v[0] / v[2], -v[1] / v[2]};
}

TEST(Coordinates, ThePageHasEveryEngine) { EXPECT_EQ(RowsOfThePage().size(), Engines().size()); }

TEST(Coordinates, TheAvatarStandsAsTheEnginesCharactersDo) {
  for (const auto& [name, row] : RowsOfThePage()) {
    const Engine engine = Engines().at(name);
    // FLAME: +x to the subject's left, y up, the face towards +z.
    EXPECT_EQ((row.engine_from_cosplat * Vector{-1, 0, 0}), engine.unit * engine.right) << name;
    EXPECT_EQ((row.engine_from_cosplat * Vector{0, 1, 0}), engine.unit * engine.up) << name;
    EXPECT_EQ((row.engine_from_cosplat * Vector{0, 0, 1}), engine.unit * engine.forward) << name;
  }
}

TEST(Coordinates, BothCamerasSeeThePointAtTheSamePixel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto vector = [&] { return Vector{any(random), any(random), any(random)}; };
  for (const auto& [name, row] : RowsOfThePage()) {
    const Engine engine = Engines().at(name);
    for (int round = 0; round < 100; ++round) {
      // V and O as the engine has them: any turns, any places, in its unit.
      Matrix view = Turn(vector());
      if (engine.mirrored_view)
        for (double& x : view[2]) x = -x;
      const Matrix object = Turn(vector());
      const Vector view_at = engine.unit * vector(), object_at = engine.unit * vector();
      const Matrix rotation = row.opencv_from_view * (view * (object * row.engine_from_cosplat));
      const Vector translation = row.opencv_from_view * (view * object_at + view_at);
      // cosplat_set_camera wants a rotation.
      EXPECT_NEAR(Determinant(rotation), 1, 1e-9) << name;
      for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) {
          double product = 0;
          for (size_t k = 0; k < 3; ++k) product += rotation[i][k] * rotation[j][k];
          EXPECT_NEAR(product, i == j, 1e-9) << name;
        }
      const Vector p = vector();
      const Vector in_cam = rotation * p + translation;
      const auto seen =
          Seen(engine, view * (object * (row.engine_from_cosplat * p) + object_at) + view_at);
      EXPECT_NEAR(in_cam[0] / in_cam[2], seen[0], 1e-9 * (1 + std::abs(seen[0]))) << name;
      EXPECT_NEAR(in_cam[1] / in_cam[2], seen[1], 1e-9 * (1 + std::abs(seen[1]))) << name;
    }
  }
}

TEST(Coordinates, TurnsTurnTheAvatarAsTheEngineDoes) {
  const Vector turn = {0.3, -0.5, 0.7};  // of the engine's
  for (const auto& [name, row] : RowsOfThePage()) {
    const Matrix engine = Turn(turn) * row.engine_from_cosplat;
    const Matrix ours = row.engine_from_cosplat * Turn(row.turns * turn);
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) EXPECT_NEAR(engine[i][j], ours[i][j], 1e-9) << name;
  }
}

// The intrinsics that the page takes from an OpenGL projection with a shifted lens.
TEST(Coordinates, IntrinsicsOfAProjectionMatrix) {
  const double width = 640, height = 360, p00 = 1.3, p11 = 2.2, p02 = 0.1, p12 = -0.2;
  const Vector v = {0.2, -0.3, -2};  // in view space
  const double x = width / 2 * (1 + (p00 * v[0] + p02 * v[2]) / -v[2]);
  const double y = height / 2 * (1 - (p11 * v[1] + p12 * v[2]) / -v[2]);
  const double fx = width * p00 / 2, fy = height * p11 / 2;
  const double cx = width * (1 - p02) / 2, cy = height * (1 + p12) / 2;
  EXPECT_NEAR(fx * v[0] / -v[2] + cx, x, 1e-12);
  EXPECT_NEAR(fy * -v[1] / -v[2] + cy, y, 1e-12);
}

}  // namespace
