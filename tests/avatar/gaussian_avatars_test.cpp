// avatar/io/gaussian_avatars.h: avatars of GaussianAvatars look here as its own formulas place
// their Gaussians, at rest and with expressions, and damaged files give one line.
#include "avatar/io/gaussian_avatars.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "avatar/io/avatar_file.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/play/player.h"
#include "splat/base/rng.h"
#include "splat/io/ply.h"
#include "tests/avatar/gaussian_avatars_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

using Vector = math::Vec3<double>;
using Matrix = math::Mat3<double>;

Vector VectorOf(const std::vector<float>& array, size_t i) {
  return {array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}

// A Gaussian in the world, by Qian et al. 2024 and its released code, in double precision.
struct WorldRow {
  Vector mean;
  Matrix covariance;
  math::Quat<double> rotation;
  double scale = 0;  // of the face
};
WorldRow OracleOf(const BoundRow& row,
                  const std::vector<std::array<int32_t, 3>>& faces,
                  const std::vector<float>& vertices) {
  const auto& face = faces[size_t(row.binding)];
  const Vector v0 = VectorOf(vertices, size_t(face[0])), v1 = VectorOf(vertices, size_t(face[1])),
               v2 = VectorOf(vertices, size_t(face[2]));
  const auto unit = [](const Vector& v) { return v * (1 / std::sqrt(Dot(v, v))); };
  const Vector a0 = unit(v1 - v0), a1 = unit(Cross(a0, v2 - v0)), a2 = -unit(Cross(a1, a0));
  const Matrix frame{{a0.x, a1.x, a2.x, a0.y, a1.y, a2.y, a0.z, a1.z, a2.z}};
  const double scale = (std::sqrt(Dot(v1 - v0, v1 - v0)) + std::abs(Dot(a2, v2 - v0))) / 2;
  const math::Quat<double> local = math::Normalize(
      math::Quat<double>{row.rotation[0], row.rotation[1], row.rotation[2], row.rotation[3]});
  const Matrix rotation = frame * math::RotationOf(local);
  Matrix stretched = rotation;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      stretched(r, c) *= scale * std::exp(double(row.scale_log[size_t(c)]));
  const Vector offset{row.position[0], row.position[1], row.position[2]};
  return {(v0 + v1 + v2) * (1.0 / 3) + frame * offset * scale,
          stretched * Transpose(stretched),
          math::Multiply(math::QuatOfRotation(frame), local),
          scale};
}

Matrix CovarianceOf(const PosedGaussians& g, size_t i) {
  const math::Quat<double> q = math::Normalize(math::Quat<double>{
      g.rotation[4 * i], g.rotation[4 * i + 1], g.rotation[4 * i + 2], g.rotation[4 * i + 3]});
  Matrix m = math::RotationOf(q);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) *= std::exp(double(g.scale_log[3 * i + size_t(c)]));
  return m * Transpose(m);
}

std::array<double, 2> PixelOf(const Camera& camera, const Vector& p) {
  const auto& r = camera.rotation;
  const auto& t = camera.translation;
  const double x = r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0];
  const double y = r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1];
  const double z = r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2];
  return {camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy};
}

// A head, its Gaussians and its track, in GaussianAvatars' files.
struct Made {
  TemporaryFolder folder;
  FlameModel flame;
  std::vector<BoundRow> rows;
  std::vector<FlameParams> frames;
  std::vector<float> shape;
  std::string ply = folder / "point_cloud.ply", npz = folder / "flame_param.npz";

  // with_teeth: the mesh that the rows are on has VHAP's.
  Made(FlameModel model, size_t count, bool with_teeth = false) : flame(std::move(model)) {
    shape.assign(size_t(flame.shape_count), 0.3f);
    frames = SomeFrames(6, size_t(flame.expression_count), 2);
    rows = RandomRows(count, flame.faces.size() + (with_teeth ? 168 : 0), 1);
    Write();
  }
  void Write() {
    WriteBoundPly(ply, rows);
    FlameParamOf(frames, shape, size_t(flame.expression_count), size_t(flame.vertex_count))
        .Write(npz);
  }
  AvatarModel Read() const { return ReadGaussianAvatar(ply, flame); }
};

Made MadeHead(size_t count = 2000) { return Made(MakeProceduralHead(), count); }

// What the avatar's posed Gaussians should be.
void ExpectOraclesGaussians(const Made& made) {
  const AvatarModel model = made.Read();
  const FlameModel flame = FlameOf(model, made.flame);
  Player player(model, flame);
  const Camera camera = procedural::OrbitCamera(0.3f, 0.1f, 0.9f, 512);
  double worst = 0;
  for (const FlameParams& frame : made.frames) {
    PosedAvatar placed;
    player.Pose(frame, placed);
    const std::vector<float>& vertices = player.VerticesOf(placed);
    const PosedGaussians& posed = player.GaussiansOf(placed);
    for (size_t i = 0; i < made.rows.size(); ++i) {
      const WorldRow expected = OracleOf(made.rows[i], flame.faces, vertices);
      const Vector mean{
          posed.position[3 * i], posed.position[3 * i + 1], posed.position[3 * i + 2]};
      const auto a = PixelOf(camera, mean), b = PixelOf(camera, expected.mean);
      worst = std::max(worst, std::hypot(a[0] - b[0], a[1] - b[1]));
      const Matrix covariance = CovarianceOf(posed, i);
      const double size =
          expected.covariance(0, 0) + expected.covariance(1, 1) + expected.covariance(2, 2);
      for (int k = 0; k < 9; ++k)
        ASSERT_NEAR(covariance.m[k], expected.covariance.m[k], 1e-3 * size) << i;
    }
  }
  EXPECT_LT(worst, 0.001);  // px at 512 x 512, where 2 would do; measured 4e-5
}

TEST(GaussianAvatars, GaussiansAreWhereTheirRulePutsThem) { ExpectOraclesGaussians(MadeHead()); }

TEST(GaussianAvatars, OnVhapsTeethToo) {
  Made made(FlameSizedTube(), 3000, true);
  for (size_t i = 0; i < 336; ++i) made.rows[i].binding = float(9976 + i % 168);
  made.Write();
  const AvatarModel model = made.Read();
  EXPECT_TRUE(model.has_vhap_teeth);
  EXPECT_EQ(model.mesh.faces.size(), 9976u + 168);
  EXPECT_EQ(model.static_offset.size(), 3 * (5023u + 120));
  ExpectOraclesGaussians(made);
}

// The static offset with rows for the teeth, as VHAP exports it, moves them.
TEST(GaussianAvatars, KeepsTheTeethsOffsets) {
  Made made(FlameSizedTube(), 10);
  const std::vector<float> without = made.Read().mesh.vertices;
  FlameParamOf(made.frames, made.shape, 5, 5143).Write(made.npz);
  const AvatarModel model = made.Read();
  EXPECT_EQ(model.static_offset.back(), 0);
  EXPECT_EQ(model.static_offset[3 * 5142], 0.0005f);
  EXPECT_EQ(model.mesh.vertices.size(), without.size());
  EXPECT_NE(model.mesh.vertices[3 * 5142], without[3 * 5142]);
}

// The oracle's Gaussians of a frame as a scene.
Gaussians SceneOf(const Made& made, const FlameModel& flame, const std::vector<float>& vertices) {
  Gaussians scene = ReadPly(made.ply);
  for (size_t i = 0; i < made.rows.size(); ++i) {
    const WorldRow row = OracleOf(made.rows[i], flame.faces, vertices);
    const double mean[3] = {row.mean.x, row.mean.y, row.mean.z};
    const double rotation[4] = {row.rotation.w, row.rotation.x, row.rotation.y, row.rotation.z};
    for (int k = 0; k < 3; ++k) {
      scene.at(kPosition, i)[k] = float(mean[k]);
      scene.at(kScaleLog, i)[k] += float(std::log(row.scale));
    }
    for (int k = 0; k < 4; ++k) scene.at(kRotation, i)[k] = float(rotation[k]);
  }
  return scene;
}

double PsnrOf(const Buffer<float>& a, const Buffer<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return -10 * std::log10(sum / double(a.size()) + 1e-30);
}

// The lowest PSNR over the frames, the avatar's against a scene made by the oracle.
double PsnrAgainstScenes(const Made& made, const AvatarModel& model) {
  const FlameModel flame = FlameOf(model, made.flame);
  Player player(model, flame);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  std::vector<FlameParams> frames = made.frames;
  frames.push_back(*model.canonical_frame);
  double min = 1e9;
  for (const FlameParams& frame : frames) {
    PosedAvatar placed;
    player.Pose(frame, placed);
    const Camera camera = procedural::OrbitCamera(0.4f, 0.1f, 0.9f, 256);
    const Gaussians scene = SceneOf(made, flame, player.VerticesOf(placed));
    RenderedImage expected;
    rasterizer->Forward(
        ViewOf(scene), scene.basis, camera, {{1, 1, 1}, scene.degree}, expected, *tape);
    min = std::min(min, PsnrOf(player.Draw(placed, camera, {1, 1, 1}).color, expected.color));
  }
  return min;
}

TEST(GaussianAvatars, LookLikeTheirGaussiansDrawnAsAScene) {
  const Made made = MadeHead(6000);
  EXPECT_GT(PsnrAgainstScenes(made, made.Read()), 90);  // dB; measured 103
}

TEST(GaussianAvatars, AreKeptInAvatarFiles) {
  Made made(FlameSizedTube(), 3000, true);
  const AvatarModel model = made.Read();
  const FlameModel flame = FlameOf(model, made.flame);
  const std::string path = made.folder / "avatar.glb";
  WriteAvatarGlb(path, model, &flame);
  const GlbSummary summary = SummarizeGlb(path);
  EXPECT_EQ(summary.avatar.value().version, 3);
  for (const char* part : {"GaussianAvatars' rule", "VHAP's teeth added", "in the world frame"})
    EXPECT_NE(ToString(summary).find(part), std::string::npos) << part;
  AvatarModel read = ReadAvatarGlb(path);
  EXPECT_TRUE(read.embedding.rigid && read.has_vhap_teeth && !read.has_mouth);
  AttachMesh(read, FlameOf(read, made.flame));
  EXPECT_EQ(read.mesh.vertices, model.mesh.vertices);
  for (int a = 0; a < kAttributeCount; ++a)
    EXPECT_EQ(read.gaussians.values[a], model.gaussians.values[a]);
  EXPECT_EQ(read.trained_range->expression_most, model.trained_range->expression_most);
  EXPECT_GT(PsnrAgainstScenes(made, read), 90);

  AvatarModel unattached = ReadAvatarGlb(path);
  unattached.static_offset.clear();
  unattached.embedding.triangle = {0};
  ExpectError([&] { AttachMesh(unattached, made.flame); }, {"flame", "has VHAP's teeth added"});
  ExpectError([&] { FlameOf(unattached, MakeProceduralHead()); }, {"VHAP's teeth", "5023"});
}

// The shape, the range of faces and the head's place are the track's.
TEST(GaussianAvatars, KnowTheirSubject) {
  const Made made = MadeHead(50);
  const AvatarModel model = made.Read();
  EXPECT_EQ(model.shape, made.shape);
  EXPECT_EQ(model.color_frame, ColorFrame::kWorld);
  EXPECT_EQ(model.trained_range->expression_least, RangeOf(made.frames).expression_least);
  EXPECT_EQ(model.trained_range->angle, RangeOf(made.frames).angle);
  EXPECT_EQ(model.canonical_frame->pose[0], MeanRoot(made.frames).pose[0]);
  const FlameParams rest = RestRoot(model, made.flame);
  EXPECT_EQ(rest.translation, MeanRoot(made.frames).translation);
  // Kept elsewhere, it can be named in place of the data set.
  std::filesystem::rename(made.npz, made.folder / "motion.npz");
  EXPECT_EQ(ReadGaussianAvatar(made.ply, made.flame, made.folder / "motion.npz").shape, made.shape);
  std::filesystem::rename(made.folder / "motion.npz", made.npz);
  const std::string summary = SummarizeGaussianAvatar(made.ply);
  for (const char* part : {"50 Gaussians", "degree 3", "6 frames", "a static offset"})
    EXPECT_NE(summary.find(part), std::string::npos) << summary;
}

// flame_param.npz has a row of zeros for a moment that the track does not have.
TEST(GaussianAvatars, SkipMomentsWithoutAFrame) {
  Made made = MadeHead(5);
  const TrainedRange range = RangeOf(made.frames);
  const FlameParams root = MeanRoot(made.frames);
  made.frames.insert(made.frames.begin() + 2, FlameParams());
  made.Write();
  const AvatarModel model = made.Read();
  EXPECT_EQ(model.trained_range->expression_least, range.expression_least);
  EXPECT_EQ(model.canonical_frame->pose[0], root.pose[0]);
}

TEST(GaussianAvatars, AreRecognisedByTheirBinding) {
  Made made = MadeHead(5);
  EXPECT_TRUE(IsGaussianAvatarPly(made.ply));
  WriteBoundPly(made.ply, made.rows, "");
  EXPECT_FALSE(IsGaussianAvatarPly(made.ply));
  ExpectError([&] { made.Read(); }, {made.ply, "binding_0"});
}

TEST(GaussianAvatars, RefuseAFaceThatIsNone) {
  Made made = MadeHead(5);
  const std::string faces = std::to_string(made.flame.faces.size());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [value, shown] : std::vector<std::pair<float, std::string>>{
           {float(made.flame.faces.size()), faces}, {-1, "-1"}, {2.5f, "2.5"}, {nan, "nan"}}) {
    made.rows[3].binding = value;
    made.Write();
    ExpectError([&] { made.Read(); }, {made.ply, "vertex 3", "binding_0", shown, faces});
  }
}

TEST(GaussianAvatars, RefuseNumbersThatAreNotFinite) {
  Made made = MadeHead(5);
  made.rows[2].scale_log[1] = std::numeric_limits<float>::infinity();
  made.Write();
  ExpectError([&] { made.Read(); }, {made.ply, "vertex 2", "scale_1", "not finite"});
}

TEST(GaussianAvatars, RefuseASubjectThatDoesNotFit) {
  Made made = MadeHead(5);
  const size_t expressions = size_t(made.flame.expression_count);
  const auto with = [&](const std::string& name, std::vector<size_t> shape, float value) {
    Npz npz = FlameParamOf(made.frames, made.shape, expressions, size_t(made.flame.vertex_count));
    size_t count = 1;
    for (const size_t extent : shape) count *= extent;
    npz.Add(name, std::move(shape), std::vector<float>(count, value));
    npz.Write(made.npz);
  };
  with("static_offset", {1, 7, 3}, 0.1f);
  ExpectError([&] { made.Read(); }, {"flame_param.npz", "static_offset", "21"});
  with("shape", {0}, 0);
  ExpectError([&] { made.Read(); }, {"flame_param.npz", "shape"});
  with("shape", {4}, std::numeric_limits<float>::quiet_NaN());
  ExpectError([&] { made.Read(); }, {"flame_param.npz", "shape"});
  with("shape", {size_t(made.flame.shape_count) + 1}, 1);
  ExpectError([&] { made.Read(); }, {"shape", std::to_string(made.flame.shape_count)});
  with("rotation", {made.frames.size(), 4}, 0.1f);
  ExpectError([&] { made.Read(); }, {"flame_param.npz", "rotation", "4"});
  with("neck_pose", {made.frames.size() - 1, 3}, 0.1f);
  ExpectError([&] { made.Read(); }, {"flame_param.npz", "neck_pose"});
  with("dynamic_offset", {made.frames.size(), 2, 3}, 0.1f);
  ExpectError([&] { made.Read(); }, {"flame_param.npz", "dynamic_offset"});
  std::filesystem::remove(made.npz);
  ExpectError([&] { made.Read(); }, {made.ply, "flame_param.npz", "data set"});
  ExpectError([&] { ReadGaussianAvatar(made.ply, made.flame, made.folder / "none"); }, {"none"});
}

// A file that ends early or has other bytes is refused in one line, or is an avatar.
TEST(GaussianAvatars, DamagedFilesAreRefusedOrRead) {
  const Made made = MadeHead(8);
  const std::vector<char> whole = ReadFile(made.ply);
  const std::string bytes(whole.begin(), whole.end());
  Rng rng{7};
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    std::string damaged = bytes;
    if (i % 2 == 0) damaged.resize(rng.Below(bytes.size()));
    for (int k = 0; i % 2 == 1 && k < 3; ++k)
      damaged[rng.Below(bytes.size())] = char(rng.Below(256));
    WriteFileAtomically(made.ply, damaged);
    try {
      const AvatarModel model = made.Read();
      for (const int32_t face : model.embedding.triangle)
        EXPECT_LT(size_t(face), made.flame.faces.size());
    } catch (const Error& error) {
      ++refused;
      EXPECT_NE(std::string(error.what()).find(made.ply), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GE(refused, 30);  // every file that ends early
}

}  // namespace
}  // namespace cosplat::test
