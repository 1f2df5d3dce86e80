// avatar/surface/silhouette.h: which pixels a mesh covers, and where the mouth is.
#include "avatar/surface/silhouette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "assets/head/video.h"
#include "tests/avatar/meshes.h"

namespace cosplat::test {
namespace {

// One pixel per unit at depth 1.
Camera Plain(int width, int height) {
  Camera c;
  c.width = width;
  c.height = height;
  c.fx = c.fy = 1;
  return c;
}

size_t Count(const std::vector<uint8_t>& mask) {
  return size_t(std::count(mask.begin(), mask.end(), 1));
}

TEST(Silhouette, CoversPixelsWhoseCentreIsInside) {
  const std::vector<float> vertices{1, 1, 1, 5, 1, 1, 1, 5, 1};
  for (const std::array<int32_t, 3> face : {std::array{0, 1, 2}, std::array{0, 2, 1}}) {
    const std::vector<uint8_t> mask = MeshSilhouette(vertices, {face}, Plain(8, 6));
    ASSERT_EQ(mask.size(), 48u);
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x)
        EXPECT_EQ(mask[8 * y + x], x >= 1 && y >= 1 && (x - 0.5f) + (y - 0.5f) <= 4) << x << y;
  }
}

TEST(Silhouette, ClipsToTheImageAndLeavesOutWhatIsBehind) {
  const std::vector<std::array<int32_t, 3>> face{{0, 1, 2}};
  EXPECT_EQ(Count(MeshSilhouette({-99, -99, 1, 99, -99, 1, 0, 99, 1}, face, Plain(8, 6))), 48u);
  EXPECT_EQ(Count(MeshSilhouette({1, 1, -1, 5, 1, -1, 1, 5, -1}, face, Plain(8, 6))), 0u);
  EXPECT_EQ(Count(MeshSilhouette({1, 1, 1, 5, 1, 1, 1, 5, -1}, face, Plain(8, 6))), 0u);
  EXPECT_EQ(Count(MeshSilhouette({1e9f, 0, 1, 2e9f, 0, 1, 0, 2e9f, 1}, face, Plain(8, 6))), 0u);
  EXPECT_EQ(Count(MeshSilhouette({}, {}, Plain(8, 6))), 0u);
}

// Points that the pixels name are where the pixels look, the nearest ones.
TEST(DrawMesh, NamesThePointBehindEachPixel) {
  const FlameModel model = MakeProceduralHead();
  const std::vector<float>& vertices = model.template_vertices;
  const Camera camera = procedural::OrbitCamera(0.5f, 0.2f, 0.9f, 96);
  const std::vector<MeshPixel> image = DrawMesh(vertices, model.faces, camera);
  const std::vector<uint8_t> mask = MeshSilhouette(vertices, model.faces, camera);
  for (size_t i = 0; i < image.size(); ++i) {
    const MeshPixel& at = image[i];
    ASSERT_EQ(at.face >= 0, mask[i] == 1) << i;
    if (at.face < 0) continue;
    const auto& f = model.faces[size_t(at.face)];
    std::array<float, 3> p{};  // in the camera
    for (int r = 0; r < 3; ++r) {
      p[r] = camera.translation[r];
      for (int k = 0; k < 3; ++k)
        p[r] += camera.rotation[3 * r + k] *
                (at.u * vertices[3 * f[0] + k] + at.v * vertices[3 * f[1] + k] +
                 (1 - at.u - at.v) * vertices[3 * f[2] + k]);
    }
    EXPECT_NEAR(p[2], at.depth, 1e-5f);
    EXPECT_NEAR(camera.fx * p[0] / p[2] + camera.cx, float(i % 96) + 0.5f, 1e-2f);
    EXPECT_NEAR(camera.fy * p[1] / p[2] + camera.cy, float(i / 96) + 0.5f, 1e-2f);
  }
  // Two triangles, one before the other, in either order.
  const std::vector<float> two{-9, -9, 2, 9, -9, 2, 0, 9, 2, -9, -9, 1, 9, -9, 1, 0, 9, 1};
  for (const bool swapped : {false, true}) {
    std::vector<std::array<int32_t, 3>> faces{{0, 1, 2}, {3, 4, 5}};
    if (swapped) std::swap(faces[0], faces[1]);
    const MeshPixel at = DrawMesh(two, faces, Plain(1, 1))[0];
    EXPECT_EQ(at.face, swapped ? 0 : 1);
    EXPECT_FLOAT_EQ(at.depth, 1);
  }
}

TEST(Silhouette, IsTheRenderersMaskOfTheHead) {
  const ProceduralHead head = MakeProceduralHeadParts();
  const Camera camera = procedural::OrbitCamera(0.3f, 0.1f, 0.9f, 96);
  const std::vector<float>& vertices = head.model.template_vertices;
  const Image8 image = RenderProceduralHead(head, vertices, {}, camera);
  const std::vector<uint8_t> mask = MeshSilhouette(vertices, head.model.faces, camera);
  size_t shown = 0, differ = 0;
  for (size_t p = 0; p < mask.size(); ++p) {
    const int alpha = image.data[4 * p + 3];
    shown += alpha == 255;
    // Strictly inside or outside; the rim is antialiased there.
    differ += (alpha == 255 && !mask[p]) || (alpha == 0 && mask[p]);
  }
  EXPECT_GT(shown, 1000u);
  EXPECT_LE(differ, 2u);
}

constexpr int kAll = 1 << 30;  // all vertices are the head's

TEST(MouthBox, SurroundsTheLips) {
  const FlameModel head = MakeProceduralHead();
  const MeshTopology topology = BuildTopology(head.name, head.faces, head.vertex_count);
  const Camera camera = procedural::OrbitCamera(0, 0, 0.9f, 96);
  const std::vector<float>& v = head.template_vertices;
  const Crop box = MouthBox(v, v, topology, kAll, camera);
  EXPECT_GT(box.width, 5);
  EXPECT_LT(box.width, 60);
  EXPECT_GT(box.height, 5);
  // Below the middle of the face, in the middle of the image.
  EXPECT_NEAR(box.x + box.width / 2.0, 48, 4);
  EXPECT_GT(box.y + box.height / 2.0, 48);
  EXPECT_LE(box.x + box.width, 96);
  EXPECT_LE(box.y + box.height, 96);

  // It moves with the head, and is nothing once that is out of sight or behind.
  std::vector<float> moved = v;
  for (size_t i = 0; i < moved.size(); i += 3) moved[i] += 0.03f;
  EXPECT_GT(MouthBox(moved, v, topology, kAll, camera).x, box.x);
  for (size_t i = 0; i < moved.size(); i += 3) moved[i] += 10;
  EXPECT_TRUE(MouthBox(moved, v, topology, kAll, camera).empty());
  for (size_t i = 0; i < moved.size(); i += 3) moved[i + 2] += 10;
  EXPECT_TRUE(MouthBox(moved, v, topology, kAll, camera).empty());
}

TEST(MouthBox, IsNothingWithoutAMouth) {
  const CanonicalMesh ball = SphereMesh(2);
  const MeshTopology topology = BuildTopology("ball", ball.faces, int(ball.vertices.size() / 3));
  EXPECT_TRUE(MouthBox(ball.vertices, ball.vertices, topology, kAll, Plain(8, 6)).empty());
  const CanonicalMesh sheet = SheetMesh(3);  // one boundary: a neck's
  const MeshTopology one = BuildTopology("sheet", sheet.faces, int(sheet.vertices.size() / 3));
  EXPECT_TRUE(MouthBox(sheet.vertices, sheet.vertices, one, kAll, Plain(8, 6)).empty());
}

// With room on all sides, above the chin's row and as the camera's image allows.
TEST(HeadBox, HasTheHeadWithoutShoulders) {
  const FlameModel head = MakeProceduralHead();
  const std::vector<float>& v = head.template_vertices;
  const Camera camera = procedural::OrbitCamera(0, 0, 0.9f, 96);
  const Crop box = HeadBox(v, head, camera);
  const int chin = ChinRow(v, head, camera);
  EXPECT_GT(box.y + box.height, chin);
  EXPECT_LT(box.y + box.height, chin + 20);
  EXPECT_GT(box.width, 30);
  EXPECT_LT(box.width, 90);
  const Crop mouth =
      MouthBox(v, v, BuildTopology(head.name, head.faces, head.vertex_count), kAll, camera);
  EXPECT_GT(mouth.x, box.x);
  EXPECT_LT(mouth.x + mouth.width, box.x + box.width);

  std::vector<float> moved = v;
  for (size_t i = 0; i < moved.size(); i += 3) moved[i] += 10;
  EXPECT_TRUE(HeadBox(moved, head, camera).empty());
  for (size_t i = 0; i < moved.size(); i += 3) moved[i + 2] += 10;
  EXPECT_TRUE(HeadBox(moved, head, camera).empty());
}

}  // namespace
}  // namespace cosplat::test
