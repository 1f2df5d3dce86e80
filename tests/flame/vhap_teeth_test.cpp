// flame/vhap_teeth.h: the teeth that GaussianAvatars' faces 9976 and up are on.
#include "flame/vhap_teeth.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "assets/head/procedural_head.h"
#include "flame/model.h"
#include "flame/mouth.h"
#include "flame/pose.h"
#include "flame/topology.h"
#include "tests/avatar/gaussian_avatars_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

constexpr int kOwn = 5023, kOwnFaces = 9976;

std::array<int32_t, 3> ToothFace(const FlameModel& model, size_t i) {
  std::array<int32_t, 3> face = model.faces[kOwnFaces + i];
  for (int32_t& v : face) v -= kOwn;
  return face;
}

TEST(VhapTeeth, HaveTheirVerticesAndFaces) {
  const FlameModel own = FlameSizedTube(), model = WithVhapTeeth(own);
  EXPECT_NO_THROW(Validate(model));
  EXPECT_EQ(model.vertex_count, kOwn + 120);
  EXPECT_EQ(model.own_vertex_count(), kOwn);
  ASSERT_EQ(model.faces.size(), size_t(kOwnFaces + 168));
  using Face = std::array<int32_t, 3>;
  // The first and last of each strip, on both sides of its middle.
  const std::vector<std::pair<size_t, Face>> faces = {
      {0, {0, 31, 30}},      {13, {6, 7, 37}},     {14, {7, 8, 37}},     {27, {14, 44, 43}},
      {28, {60, 75, 76}},    {41, {66, 82, 67}},   {42, {67, 82, 68}},   {55, {74, 88, 89}},
      {56, {75, 30, 76}},    {69, {82, 36, 37}},   {70, {82, 37, 38}},   {83, {88, 44, 89}},
      {84, {45, 46, 15}},    {97, {52, 22, 21}},   {98, {52, 23, 22}},   {111, {58, 59, 29}},
      {112, {90, 106, 105}}, {125, {96, 97, 112}}, {126, {97, 98, 112}}, {139, {104, 119, 118}},
      {140, {105, 106, 45}}, {153, {112, 52, 51}}, {154, {112, 53, 52}}, {167, {118, 119, 59}}};
  for (const auto& [index, face] : faces) EXPECT_EQ(ToothFace(model, index), face) << index;
  EXPECT_EQ(BuildTopology(model.name, model.faces, model.vertex_count).component_count,
            BuildTopology(own.name, own.faces, own.vertex_count).component_count + 2);
  EXPECT_EQ(WithVhapTeeth(model).vertex_count, model.vertex_count);
}

TEST(VhapTeeth, AreForFlamesMeshAlone) {
  ExpectError([] { WithVhapTeeth(MakeProceduralHead()); }, {"procedural", "VHAP", "5023"});
  FlameModel filled = FlameSizedTube();
  filled.mouth.bowl = 1;
  ExpectError([&] { WithVhapTeeth(filled); }, {"tube", "VHAP"});
}

// On FLAME's own head: behind the lips, from the subject's left to the right, upper above
// lower; the upper teeth stay with the skull, the lower teeth follow the jaw.
TEST(VhapTeeth, AreInFlamesMouth) {
  const std::string path =
      std::string(COSPLAT_SOURCE_DIR) + "/../shared/data/tracked/flame_for_tracks.npz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the shared data are not here";
  const FlameModel model = WithVhapTeeth(LoadFlameModel(path));
  const FlamePoser<float> poser(model, {});
  FlamePoser<float>::Parameters frame;
  std::vector<float> closed, open;
  poser.Forward(frame, closed);
  frame.pose[2] = {0.3f, 0, 0};
  poser.Forward(frame, open);
  const auto tooth = [&](const std::vector<float>& vertices, int row, int column) {
    return &vertices[3 * size_t(kOwn + kVhapRow * row + column)];
  };
  for (int c = 0; c < kVhapRow; ++c) {
    EXPECT_GT(tooth(closed, 0, c)[1], tooth(closed, 2, c)[1]);  // root above edge
    EXPECT_GT(tooth(closed, 2, c)[1], tooth(closed, 3, c)[1]);  // upper edge above lower
    EXPECT_LT(tooth(closed, 4, c)[2], tooth(closed, 0, c)[2]);  // back behind front
    EXPECT_FLOAT_EQ(tooth(open, 2, c)[1], tooth(closed, 2, c)[1]);
    EXPECT_LT(tooth(open, 3, c)[1], tooth(closed, 3, c)[1] - 0.005f);
    if (c > 0) EXPECT_LT(tooth(closed, 0, c)[0], tooth(closed, 0, c - 1)[0]) << c;
  }
  const float* lip = &closed[3 * 3543];  // the upper lip's middle
  EXPECT_LT(tooth(closed, 2, 7)[2], lip[2]);
  EXPECT_NEAR(tooth(closed, 2, 7)[0], lip[0], 0.002f);
}

}  // namespace
}  // namespace cosplat::test
