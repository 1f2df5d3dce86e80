#include "tests/altitudes/village.h"

#include <algorithm>
#include <cmath>

#include "assets/head/noise.h"
#include "assets/head/raster.h"

namespace cosplat {
namespace {

using procedural::FloorOf;
using procedural::HashUnit;
using procedural::Mix;
using procedural::Noise;
using procedural::Vec;
using procedural::operator*;
using procedural::operator/;

constexpr float kPi = 3.14159265f;
constexpr float kSide = 1;  // m: longer sides are divided, since the rasteriser does not clip
constexpr float kGroundHalf = 48;  // m
constexpr float kHillsBegin = 18;  // m from the middle
const Vec kSun = Normalize(Vec{0.55f, 0.35f, 0.75f});

float HeightOfGround(float x, float y) {
  const float beyond = std::max(0.0f, std::hypot(x, y) - kHillsBegin);
  const float hills = beyond * (0.08f + 0.25f * Noise({0.07f * x, 0.07f * y, 3}));
  return hills + 0.1f * (Noise({0.5f * x, 0.5f * y, 7}) - 0.5f);
}

class Builder {
 public:
  explicit Builder(Village& village) : village_(village) {}

  int Vertex(const Vec& p) {
    village_.vertices.insert(village_.vertices.end(), {p.x, p.y, p.z});
    return int(village_.vertices.size() / 3) - 1;
  }

  void Triangle(int a, int b, int c, const Paint& paint) {
    village_.faces.push_back({a, b, c});
    village_.paints.push_back(paint);
  }

  // Corners counter-clockwise as seen from outside; the texture begins at `a`, its right is a to b.
  void Quad(const Vec& a, const Vec& b, const Vec& c, const Vec& d, Material material, int seed) {
    const Vec right = Normalize(b - a), normal = Normalize(Cross(b - a, d - a));
    const Paint paint{material, a, right, Cross(normal, right), seed};
    const int columns = std::max(1, int(std::ceil(Length(b - a) / kSide)));
    const int rows = std::max(1, int(std::ceil(Length(d - a) / kSide)));
    std::vector<int> ids;
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i <= columns; ++i) {
        const float u = float(i) / float(columns), v = float(j) / float(rows);
        ids.push_back(Vertex(Mix(Mix(a, b, u), Mix(d, c, u), v)));
      }
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const int k = j * (columns + 1) + i;
        Triangle(ids[k], ids[k + 1], ids[k + columns + 2], paint);
        Triangle(ids[k], ids[k + columns + 2], ids[k + columns + 1], paint);
      }
  }

  // Four sides and a top.
  void Box(const Vec& low, const Vec& high, Material material, int seed) {
    const Vec a = low, b{high.x, low.y, low.z}, c{high.x, high.y, low.z}, d{low.x, high.y, low.z};
    const Vec up{0, 0, high.z - low.z};
    Quad(a, b, b + up, a + up, material, seed);
    Quad(b, c, c + up, b + up, material, seed);
    Quad(c, d, d + up, c + up, material, seed);
    Quad(d, a, a + up, d + up, material, seed);
    Quad(a + up, b + up, c + up, d + up, material, seed);
  }

 private:
  Village& village_;
};

void AddGround(Builder& builder) {
  const int cells = int(2 * kGroundHalf);
  const Paint paint{Material::kGround, {}, {1, 0, 0}, {0, 1, 0}, 0};
  std::vector<int> ids;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const float x = float(i) - kGroundHalf, y = float(j) - kGroundHalf;
      ids.push_back(builder.Vertex({x, y, HeightOfGround(x, y)}));
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int k = j * (cells + 1) + i;
      builder.Triangle(ids[k], ids[k + 1], ids[k + cells + 2], paint);
      builder.Triangle(ids[k], ids[k + cells + 2], ids[k + cells + 1], paint);
    }
}

// Walls from below the ground, and a gabled roof that juts out; the ridge runs along x.
void AddHouse(Builder& builder, Village& village, const Vec& middle, int seed) {
  const float half_x = 2 + HashUnit(seed, 1, 0), half_y = 1.8f + 0.7f * HashUnit(seed, 2, 0);
  const float eaves = 2.6f + HashUnit(seed, 3, 0), ridge = eaves + 1.2f + HashUnit(seed, 4, 0);
  const Vec low{middle.x - half_x, middle.y - half_y, -0.3f};
  const Vec high{middle.x + half_x, middle.y + half_y, eaves};
  builder.Box(low, high, Material::kWall, seed);
  const float over = 0.3f;
  const Vec a{low.x - over, low.y - over, eaves - 0.15f}, b{high.x + over, low.y - over, a.z};
  const Vec c{high.x + over, high.y + over, a.z}, d{low.x - over, high.y + over, a.z};
  const Vec p{a.x, middle.y, ridge}, q{b.x, middle.y, ridge};
  builder.Quad(a, b, q, p, Material::kRoof, seed);
  builder.Quad(c, d, p, q, Material::kRoof, seed);
  for (const auto& [u, v, top] : {std::array{b, c, q}, std::array{d, a, p}}) {
    const Paint paint{Material::kWood, u, Normalize(v - u), {0, 0, 1}, seed};
    builder.Triangle(builder.Vertex(u), builder.Vertex(v), builder.Vertex(top), paint);
  }
  village.blockers.push_back({low, {high.x, high.y, 0.5f * (eaves + ridge)}});
}

// A trunk, and leaves in a ball.
void AddTree(Builder& builder, Village& village, float x, float y, int seed) {
  const float radius = 1 + 0.6f * HashUnit(seed, 1, 1), trunk = 1.6f + HashUnit(seed, 2, 1);
  const Vec foot{x, y, HeightOfGround(x, y) - 0.1f}, middle = foot + Vec{0, 0, trunk + radius};
  builder.Box(
      foot - Vec{0.12f, 0.12f, 0}, foot + Vec{0.12f, 0.12f, trunk + 0.5f}, Material::kTrunk, seed);
  for (int k = 0; k < 220; ++k) {
    const float z = 2 * HashUnit(seed, k, 2) - 1, turn = 2 * kPi * HashUnit(seed, k, 3);
    const float wide = std::sqrt(1 - z * z);
    const Vec out{wide * std::cos(turn), wide * std::sin(turn), z};
    const Vec at = middle + out * (radius * std::cbrt(0.3f + 0.7f * HashUnit(seed, k, 4)));
    const float spin = 2 * kPi * HashUnit(seed, k, 5), half = 0.14f + 0.1f * HashUnit(seed, k, 6);
    const Vec side = Normalize(Cross(out, {0.3f, 0.1f, 1}));
    const Vec right = side * std::cos(spin) + Cross(out, side) * std::sin(spin);
    const Vec up = Normalize(Cross(out, right) + out * (HashUnit(seed, k, 7) - 0.5f));
    builder.Quad(at - right * half - up * half,
                 at + right * half - up * half,
                 at + right * half + up * half,
                 at - right * half + up * half,
                 Material::kLeaf,
                 seed + k);
  }
  const Vec ball{radius, radius, radius};
  village.blockers.push_back({middle - ball, middle + ball, true});
}

void AddFence(Builder& builder, const Vec& from, const Vec& to) {
  const int posts = int(Length(to - from) / 0.5f);
  for (int k = 0; k <= posts; ++k) {
    const Vec p = Mix(from, to, float(k) / float(posts));
    const float height = 0.8f + 0.15f * HashUnit(k, 5, 5);
    builder.Box(p - Vec{0.05f, 0.05f, 0.2f}, p + Vec{0.05f, 0.05f, height}, Material::kWood, k);
  }
  const bool along_x = std::abs(to.x - from.x) > std::abs(to.y - from.y);
  const Vec thick = along_x ? Vec{0, 0.02f, 0} : Vec{0.02f, 0, 0};
  for (const float z : {0.3f, 0.6f})
    builder.Box(
        from - thick + Vec{0, 0, z}, to + thick + Vec{0, 0, z + 0.08f}, Material::kWood, 77);
}

// The share of the sun that reaches a point, 0 to 1.
float Sunlight(const Village& village, const Vec& p) {
  for (const Blocker& b : village.blockers) {
    if (b.ball) {
      const Vec to_middle = 0.5f * (b.low + b.high) - p;
      const float along = Dot(to_middle, kSun), radius = 0.5f * (b.high.x - b.low.x);
      const float off = Length(to_middle - kSun * along);
      if (along > 0 && off < radius && Length(to_middle) > radius) return 0.25f;
      continue;
    }
    float near = 0.05f, far = 1e9f;
    for (int i = 0; i < 3; ++i) {  // the slabs between opposite sides
      const float s = (b.low[i] - p[i]) / kSun[i], t = (b.high[i] - p[i]) / kSun[i];
      near = std::max(near, std::min(s, t));
      far = std::min(far, std::max(s, t));
    }
    if (near < far) return 0.1f;
  }
  return 1;
}

// What is left of a pattern with `cells` per metre in a pixel that covers `footprint` metres.
float Visible(float cells, float footprint) {
  return std::clamp(1.5f - cells * footprint, 0.0f, 1.0f);
}

// Noise of several octaves, mean 0, about [-0.5, 0.5].
float Texture(const Vec& p, float cells, int octaves, float footprint) {
  float sum = 0, weight = 0.5f;
  for (int k = 0; k < octaves; ++k, cells *= 2, weight *= 0.85f)
    sum +=
        weight * Visible(cells, footprint) * (Noise(p * cells + Vec{9.0f * float(k), 0, 0}) - 0.5f);
  return sum;
}

Vec Ground(const Vec& p, float footprint) {
  const float path = std::abs(p.y - 2 * std::sin(0.25f * p.x)) - 1.4f;
  const float on_path = std::clamp(0.5f - 2 * path - 3 * Texture(p, 1, 4, footprint), 0.0f, 1.0f);
  const Vec grass = Vec{0.30f, 0.42f, 0.18f} * (1 + 1.3f * Texture(p, 0.5f, 8, footprint));
  const Vec stones =
      Vec{0.62f, 0.55f, 0.45f} * (1 + 0.8f * Texture(p + Vec{0, 0, 5}, 2, 7, footprint));
  return Mix(grass, stones, on_path);
}

Vec Bricks(float u, float v, int seed, float footprint) {
  const int row = FloorOf(v / 0.12f);
  const float shifted = u / 0.3f + (row % 2 ? 0.5f : 0.0f);
  const int column = FloorOf(shifted);
  const float from_joint = std::min({shifted - float(column),
                                     float(column + 1) - shifted,
                                     0.4f * (v / 0.12f - float(row)),
                                     0.4f * (float(row + 1) - v / 0.12f)});
  const float tone = HashUnit(seed, 8, 8);
  const Vec brick = Mix(Vec{0.62f, 0.30f, 0.22f}, Vec{0.80f, 0.72f, 0.58f}, tone);
  const float seen = Visible(8, footprint);
  const Vec own = brick * (1 + 0.35f * seen * (HashUnit(row, column, seed) - 0.5f));
  return from_joint < 0.04f ? Mix(own, {0.75f, 0.73f, 0.70f}, 0.8f * Visible(40, footprint)) : own;
}

// Bricks with a row of windows, whose panes mirror the sky.
Vec Wall(float u, float v, const Vec& mirrored, int seed, float footprint) {
  const float in_cell = u / 1.4f - float(FloorOf(u / 1.4f)) - 0.5f, above = v - 1.6f;
  const float across = std::abs(in_cell) * 1.4f;
  if (across < 0.42f && above > -0.1f && above < 1) {
    const bool frame = across > 0.36f || across < 0.025f || above < 0 || above > 0.93f ||
                       std::abs(above - 0.6f) < 0.025f;
    const Vec pane = Mix(Vec{0.12f, 0.14f, 0.18f},
                         Vec{0.75f, 0.85f, 0.97f},
                         std::clamp(0.5f + mirrored.z, 0.0f, 1.0f));
    return frame ? Mix(pane, {0.92f, 0.90f, 0.86f}, Mix(0.3f, 1, Visible(17, footprint))) : pane;
  }
  return Bricks(u, v, seed, footprint);
}

Vec Roof(float u, float v, int seed, float footprint) {
  const int row = FloorOf(v / 0.25f), column = FloorOf(u / 0.2f + (row % 2 ? 0.5f : 0.0f));
  const float within = v / 0.25f - float(row), seen = Visible(5, footprint);
  const Vec tile =
      HashUnit(seed, 9, 9) < 0.5f ? Vec{0.55f, 0.25f, 0.18f} : Vec{0.33f, 0.34f, 0.38f};
  return tile * (1 + seen * (0.4f * (HashUnit(row, column, seed + 50) - 0.5f) -
                             0.35f * Visible(27, footprint) * (within < 0.15f) + 0.05f));
}

}  // namespace

Village MakeVillage() {
  Village village;
  Builder builder(village);
  AddGround(builder);
  int seed = 0;
  for (const auto& [x, y] : {std::array{-11.0f, 9.0f},
                             {-3.5f, 12.0f},
                             {5.0f, 11.0f},
                             {12.0f, 7.5f},
                             {12.5f, -6.0f},
                             {4.0f, -11.5f},
                             {-4.5f, -12.0f},
                             {-12.5f, -7.0f}})
    AddHouse(builder, village, {x, y, 0}, ++seed);
  for (const auto& [x, y] : {std::array{-5.0f, 5.5f},
                             {5.5f, 5.0f},
                             {8.0f, -3.5f},
                             {-7.0f, -5.0f},
                             {0.5f, -6.5f},
                             {17.0f, 1.0f},
                             {-17.0f, 2.0f},
                             {0.0f, 17.5f},
                             {9.0f, 15.0f},
                             {-9.5f, -15.0f}})
    AddTree(builder, village, x, y, 100 * ++seed);
  AddFence(builder, {-8, 6.2f, 0}, {-2, 6.2f, 0});
  AddFence(builder, {3.2f, -7.5f, 0}, {3.2f, -4, 0});
  return village;
}

std::array<float, 3> PaintVillage(const Village& village,
                                  int face,
                                  const std::array<float, 3>& barycentrics,
                                  const Vec& eye,
                                  float pixel_angle) {
  const auto& ids = village.faces[size_t(face)];
  std::array<Vec, 3> corner{};
  Vec p{};
  for (int i = 0; i < 3; ++i) {
    const float* v = &village.vertices[3 * size_t(ids[size_t(i)])];
    corner[size_t(i)] = {v[0], v[1], v[2]};
    p += corner[size_t(i)] * barycentrics[size_t(i)];
  }
  const Paint& paint = village.paints[size_t(face)];
  Vec normal = Normalize(Cross(corner[1] - corner[0], corner[2] - corner[0]));
  const Vec look = Normalize(p - eye);
  const float facing = -Dot(look, normal);
  if (facing < 0) normal = -normal;
  const float footprint =
      Length(p - eye) * pixel_angle / std::max(std::sqrt(std::abs(facing)), 0.25f);
  const float u = Dot(p - paint.origin, paint.right), v = Dot(p - paint.origin, paint.up);
  Vec color{};
  switch (paint.material) {
    case Material::kGround:
      color = Ground(p, footprint);
      break;
    case Material::kWall:
      color = Wall(u, v, look - normal * (2 * Dot(look, normal)), paint.seed, footprint);
      break;
    case Material::kRoof:
      color = Roof(u, v, paint.seed, footprint);
      break;
    case Material::kTrunk:
      color = Vec{0.36f, 0.27f, 0.20f} *
              (1 + 1.2f * Texture({2 * p.x, 2 * p.y, 0.4f * p.z}, 5, 4, footprint));
      break;
    case Material::kLeaf:
      color = Mix(Vec{0.18f, 0.36f, 0.12f}, Vec{0.48f, 0.58f, 0.20f}, HashUnit(paint.seed, 4, 4)) *
              (1 + Texture(p, 6, 3, footprint));
      break;
    case Material::kWood:
      color =
          Vec{0.55f, 0.43f, 0.30f} * (1 + Texture({p.x * 3, p.y * 3, p.z * 0.6f}, 4, 5, footprint));
      break;
  }
  const float sun = std::max(0.0f, Dot(normal, kSun)) * Sunlight(village, p + normal * 0.02f);
  const float light = 0.42f + 0.12f * normal.z + 0.62f * sun;
  return {std::clamp(color.x * light, 0.0f, 1.0f),
          std::clamp(color.y * light, 0.0f, 1.0f),
          std::clamp(color.z * light, 0.0f, 1.0f)};
}

Image8 DrawVillage(const Village& village, const Camera& camera) {
  class VillageShader : public procedural::Shader {
   public:
    VillageShader(const Village& village, const Camera& camera)
        : village_(village), pixel_angle_(1 / camera.fx) {
      const auto center = camera.Center();
      eye_ = {center[0], center[1], center[2]};
    }
    std::array<float, 3> Shade(const procedural::SurfacePoint& point) const override {
      return PaintVillage(village_, point.face, point.barycentrics, eye_, pixel_angle_);
    }

   private:
    const Village& village_;
    float pixel_angle_;
    Vec eye_{};
  };
  return procedural::Rasterize(
      village.vertices, village.faces, camera, VillageShader(village, camera));
}

}  // namespace cosplat
