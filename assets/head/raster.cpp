#include "assets/head/raster.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace cosplat::procedural {
namespace {

constexpr int kSamples = 4;   // per pixel and axis
constexpr int kBandRows = 8;  // pixel rows rendered at a time
constexpr double kNearest = 1e-3;

// Edge function a x + b y + c in sample units, positive inside.
struct Edge {
  double a, b, c;
  double At(double x, double y) const { return a * x + (b * y + c); }
};

struct Triangle {
  std::array<Edge, 3> edges;  // edge i lies opposite corner i
  std::array<double, 3> inverse_depth;
  int face = 0;
  bool back = false;
  int x_begin, x_end, y_begin, y_end;  // samples
};

struct Projected {
  double x, y, inverse_depth;  // samples; inverse_depth <= 0: too close
};

// Equal up to sign for both triangles at an edge, so that no sample falls between them.
Edge MakeEdge(const std::vector<Projected>& points, int from, int to) {
  const bool swap = from > to;
  const Projected& p = points[swap ? to : from];
  const Projected& q = points[swap ? from : to];
  Edge e{p.y - q.y, q.x - p.x, 0};
  e.c = -(e.a * p.x + e.b * p.y);
  if (swap) e = {-e.a, -e.b, -e.c};
  return e;
}

std::vector<Projected> Project(const std::vector<float>& vertices, const Camera& camera) {
  std::vector<Projected> points(vertices.size() / 3);
  const auto& r = camera.rotation;
  for (size_t v = 0; v < points.size(); ++v) {
    double p[3];
    for (int i = 0; i < 3; ++i)
      p[i] = double(r[3 * i]) * vertices[3 * v] + double(r[3 * i + 1]) * vertices[3 * v + 1] +
             double(r[3 * i + 2]) * vertices[3 * v + 2] + camera.translation[i];
    if (p[2] < kNearest) {
      points[v] = {0, 0, -1};
      continue;
    }
    points[v] = {kSamples * (camera.fx * p[0] / p[2] + camera.cx),
                 kSamples * (camera.fy * p[1] / p[2] + camera.cy),
                 1 / p[2]};
  }
  return points;
}

std::vector<Triangle> SetUp(const std::vector<Projected>& points,
                            const std::vector<std::array<int32_t, 3>>& faces,
                            const Camera& camera) {
  std::vector<Triangle> triangles;
  triangles.reserve(faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    const auto& corner = faces[f];
    Triangle t;
    t.face = int(f);
    double x0 = 1e30, x1 = -1e30, y0 = 1e30, y1 = -1e30;
    bool visible = true;
    for (int i = 0; i < 3; ++i) {
      const Projected& p = points[corner[i]];
      visible = visible && p.inverse_depth > 0;
      t.inverse_depth[i] = p.inverse_depth;
      t.edges[i] = MakeEdge(points, corner[(i + 1) % 3], corner[(i + 2) % 3]);
      x0 = std::min(x0, p.x), x1 = std::max(x1, p.x);
      y0 = std::min(y0, p.y), y1 = std::max(y1, p.y);
    }
    if (!visible || x1 < 0 || y1 < 0 || x0 > camera.width * kSamples ||
        y0 > camera.height * kSamples)
      continue;
    const double area = t.edges[0].At(points[corner[0]].x, points[corner[0]].y);
    if (area == 0) continue;
    t.back = area > 0;  // y grows downwards: counter-clockwise outside means a negative area
    if (area < 0)
      for (Edge& e : t.edges) e = {-e.a, -e.b, -e.c};
    t.x_begin = std::max(0, int(std::ceil(x0 - 0.5)));
    t.x_end = std::min(camera.width * kSamples - 1, int(std::floor(x1 - 0.5)));
    t.y_begin = std::max(0, int(std::ceil(y0 - 0.5)));
    t.y_end = std::min(camera.height * kSamples - 1, int(std::floor(y1 - 0.5)));
    if (t.x_begin <= t.x_end && t.y_begin <= t.y_end) triangles.push_back(t);
  }
  return triangles;
}

// The visible triangle of each sample of a few pixel rows.
struct Band {
  int first_row, rows, columns;  // samples
  std::vector<int> triangle;     // index into the set-up list, -1 nothing
  std::vector<float> inverse_depth;

  void Draw(const Triangle& t, int index) {
    const int y_end = std::min(t.y_end, first_row + rows - 1);
    for (int y = std::max(t.y_begin, first_row); y <= y_end; ++y) DrawRow(t, index, y);
  }

 private:
  void DrawRow(const Triangle& t, int index, int row) {
    const double y = row + 0.5;
    double low = t.x_begin, high = t.x_end;
    std::array<double, 3> offset;
    for (int i = 0; i < 3; ++i) {
      const Edge& e = t.edges[i];
      offset[i] = e.b * y + e.c;
      if (e.a > 0) low = std::max(low, std::floor(-offset[i] / e.a - 1.5));
      if (e.a < 0) high = std::min(high, std::ceil(-offset[i] / e.a + 0.5));
    }
    const double sum = t.edges[0].a * (t.x_begin + .5) + offset[0] +
                       t.edges[1].a * (t.x_begin + .5) + offset[1] +
                       t.edges[2].a * (t.x_begin + .5) + offset[2];
    const double scale = 1 / sum;  // the three edge functions sum to twice the area everywhere
    const size_t start = size_t(row - first_row) * columns;
    for (int x = int(low); x <= int(high); ++x) {
      const double e0 = t.edges[0].a * (x + 0.5) + offset[0];
      const double e1 = t.edges[1].a * (x + 0.5) + offset[1];
      const double e2 = t.edges[2].a * (x + 0.5) + offset[2];
      if (e0 < 0 || e1 < 0 || e2 < 0) continue;
      const float w = float(
          (e0 * t.inverse_depth[0] + e1 * t.inverse_depth[1] + e2 * t.inverse_depth[2]) * scale);
      if (w <= inverse_depth[start + x]) continue;
      inverse_depth[start + x] = w;
      triangle[start + x] = index;
    }
  }
};

SurfacePoint PointAt(const Triangle& t, double x, double y) {
  SurfacePoint point;
  point.face = t.face;
  point.back = t.back;
  double weight[3], sum = 0;
  for (int i = 0; i < 3; ++i)
    sum += weight[i] = std::max(t.edges[i].At(x, y), 0.0) * t.inverse_depth[i];
  for (int i = 0; i < 3; ++i) point.barycentrics[i] = sum > 0 ? float(weight[i] / sum) : 1 / 3.0f;
  return point;
}

// Adds the colour of the 2x2 samples at (x, y) to `color`; returns the number of covered samples.
int ShadeQuadrant(const Band& band,
                  const std::vector<Triangle>& triangles,
                  const Shader& shader,
                  int x,
                  int y,
                  float color[3]) {
  int ids[4];
  for (int k = 0; k < 4; ++k) ids[k] = band.triangle[size_t(y + k / 2) * band.columns + x + k % 2];
  int covered = 0;
  for (int k = 0; k < 4; ++k) {
    if (ids[k] < 0) continue;
    int count = 0;
    double cx = 0, cy = 0;
    for (int m = k; m < 4; ++m) {
      if (ids[m] != ids[k]) continue;
      ++count;
      cx += x + m % 2 + 0.5;
      cy += band.first_row + y + m / 2 + 0.5;
      if (m > k) ids[m] = -1;
    }
    const auto rgb = shader.Shade(PointAt(triangles[ids[k]], cx / count, cy / count));
    for (int c = 0; c < 3; ++c) color[c] += count * rgb[c];
    covered += count;
  }
  return covered;
}

void Resolve(const Band& band,
             const std::vector<Triangle>& triangles,
             const Shader& shader,
             Image8& image) {
  for (int y = 0; y < band.rows / kSamples; ++y)
    for (int x = 0; x < image.width; ++x) {
      float color[3] = {0, 0, 0};
      int covered = 0;
      for (int q = 0; q < 4; ++q)
        covered += ShadeQuadrant(
            band, triangles, shader, x * kSamples + 2 * (q % 2), y * kSamples + 2 * (q / 2), color);
      if (covered == 0) continue;
      uint8_t* pixel = &image.at(x, band.first_row / kSamples + y, 0);
      for (int c = 0; c < 3; ++c)
        pixel[c] = uint8_t(255 * std::clamp(color[c] / covered, 0.0f, 1.0f) + 0.5f);
      pixel[3] = uint8_t((255 * covered + 8) / (kSamples * kSamples));
    }
}

}  // namespace

Image8 Rasterize(const std::vector<float>& vertices,
                 const std::vector<std::array<int32_t, 3>>& faces,
                 const Camera& camera,
                 const Shader& shader) {
  const auto triangles = SetUp(Project(vertices, camera), faces, camera);
  const int bands = (camera.height + kBandRows - 1) / kBandRows;
  std::vector<std::vector<int>> of_band(bands);
  for (size_t i = 0; i < triangles.size(); ++i) {
    const int last = triangles[i].y_end / (kBandRows * kSamples);
    for (int b = triangles[i].y_begin / (kBandRows * kSamples); b <= last; ++b)
      of_band[b].push_back(int(i));
  }
  Image8 image(camera.width, camera.height, 4, 255);
  for (size_t i = 3; i < image.data.size(); i += 4) image.data[i] = 0;
  tbb::parallel_for(0, bands, [&](int b) {
    Band band;
    band.first_row = b * kBandRows * kSamples;
    band.rows = std::min(kBandRows, camera.height - b * kBandRows) * kSamples;
    band.columns = camera.width * kSamples;
    band.triangle.assign(size_t(band.rows) * band.columns, -1);
    band.inverse_depth.assign(band.triangle.size(), 0.0f);
    for (int i : of_band[b]) band.Draw(triangles[i], i);
    Resolve(band, triangles, shader, image);
  });
  return image;
}

}  // namespace cosplat::procedural
