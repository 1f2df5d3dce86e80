// FLAME's model files, tracked videos and avatars.
#include <algorithm>
#include <cmath>
#include <memory>

#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "avatar/live/score_recording.h"
#include "flame/fit/landmark_embedding.h"
#include "flame/io/imavatar_writer.h"
#include "flame/io/landmarks.h"
#include "flame/io/pickle.h"
#include "flame/io/track_layouts.h"
#include "flame/model.h"
#include "tests/avatar/gaussian_avatars_fixture.h"
#include "tests/avatar/meshes.h"
#include "tests/flame/metrical_fixture.h"
#include "tests/flame/random_model.h"
#include "tests/fuzz/reader.h"
#include "tests/support/glb_bytes.h"
#include "tests/support/random_gaussians.h"

namespace cosplat::test {
namespace {

using Strings = std::vector<std::string>;

// Archives of arrays.

std::string ReadAnyNpz(const std::string& folder, const std::string&) {
  const Npz npz = Npz::Read(folder + "/a.npz");
  for (const auto& [name, array] : npz.arrays()) {
    size_t count = 1;
    for (const size_t extent : array.shape) count *= extent;
    if (count != array.size()) return "an array without its values";
  }
  return "";
}

Npz SomeArrays() {
  Npz npz("a.npz");
  npz.Add("a", {2, 3}, std::vector<float>{1, 2, 3, 4, 5, 6});
  npz.Add("b", {4}, std::vector<int32_t>{1, 2, 3, 4});
  return npz;
}

// FLAME.

std::string ModelProblem(const FlameModel& model) {
  for (const auto& face : model.faces)
    for (const int v : face)
      if (v < 0 || v >= model.vertex_count) return "a face of no vertices";
  return NotFinite(model.template_vertices) + NotFinite(model.skinning_weights);
}

Strings FlameNpzSeeds() {
  const TemporaryFolder folder;
  WriteFlameModelNpz(folder / "m.npz", RandomModel(6, 1, 1));
  return {PartsOfZip(folder / "m.npz")};
}

Strings PickleSeeds() {
  FlameModel model = RandomModel(3, 1, 1);
  return {pickle::File(pickle::Dict(pickle::ModelItems(model)))};
}

Strings PickleAlone() {
  using namespace pickle;  // NOLINT: what the names are for
  const std::string tensor = Tensor(Storage("FloatStorage", "0", 4), 0, {2, 2}, {2, 1});
  return {File(Dict({{"flame", Dict({{"a", Floats({2}, {1, 2})}})}, {"n", Int(7)}})),
          File(Tuple({Doubles({1, 2}, {1, 2}), Text("x"), Bytes("y"), tensor}))};
}

// Any pickle: every value is asked for its numbers.
std::string ReadAnyPickle(const std::string&, const std::string& bytes) {
  const Pickle pickle("a.pkl", {bytes.begin(), bytes.end()}, [](const std::string&) {
    return std::vector<char>(16);
  });
  std::vector<const PickleValue*> values{&pickle.root()};
  for (size_t i = 0; i < values.size() && values.size() < 1000; ++i) {
    values.insert(values.end(), values[i]->items.begin(), values[i]->items.end());
    try {
      ArrayOf("a.pkl", "value", *values[i]);
    } catch (const Error&) {  // most values are no arrays
    }
  }
  return "";
}

std::string TrackProblem(const TrackedVideo& video) {
  for (const auto* frames : {&video.train, &video.test})
    for (const TrackedFrame& frame : *frames) {
      const FlameParams& p = frame.params;
      std::string problem = NotFinite(p.expression) + NotFinite(p.translation);
      for (const auto& joint : p.pose) problem += NotFinite(joint);
      problem += NotFinite(frame.camera.rotation) + NotFinite(frame.camera.translation);
      if (!problem.empty()) return problem;
    }
  return NotFinite(video.shape) + NotFinite(video.static_offset);
}

Strings TorchSeeds() {
  const Metrical metrical(1);
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.zip", TorchArchive(MetricalPickle(metrical.frames.at(0))));
  return {PartsOfZip(folder / "a.zip")};
}

std::string ReadTorch(const std::string& folder, const std::string&) {
  FlameParams params;
  Camera camera;
  if (!ReadMetricalFrame(folder + "/00000.frame", params, camera).empty()) return "";
  return NotFinite(params.expression) + NotFinite(camera.rotation);
}

std::string ReadSequence(const std::string& folder, const std::string&) {
  return TrackProblem(LoadDrivingSequence(folder));
}

std::string ReadDrivingNpz(const std::string& folder, const std::string&) {
  return TrackProblem(LoadDrivingSequence(folder + "/drive.npz"));
}

Strings ImavatarSeeds() {
  const TemporaryFolder folder;
  TrackedVideo track;
  track.shape = {0.5f, -0.25f};
  for (int i = 0; i < 4; ++i) {
    TrackedFrame frame;
    frame.name = std::to_string(i);
    frame.camera.width = frame.camera.height = 32;
    frame.camera.fx = frame.camera.fy = 60;
    frame.camera.translation = {0, 0, 1};
    frame.params.expression = {0.1f * float(i), 0.5f};
    track.train.push_back(frame);
  }
  WriteImavatarTrack(folder.path(), track, {4, {-0.5f, -0.5f, 0.5f, 0.5f}});
  return {Slurped(folder / "flame_params.json")};
}

std::string TransformsOf(const std::string& name,
                         const std::string& matrix,
                         const std::string& per_frame) {
  const std::string frame =
      R"({"file_path": "images/)" + name +
      R"(.png", "timestep_index": 0, "camera_index": 0, "transform_matrix": )" + matrix + ", " +
      per_frame + "}";
  return R"({"w": 32, "h": 24, "fl_x": 60, "fl_y": 60, "cx": 16, "cy": 12, "frames": [)" + frame +
         "]}";
}

// world_from_cam of a camera as INSTA writes it.
std::string MatrixOf(const Camera& camera) {
  const std::array<float, 3> centre = camera.Center();
  std::string rows;
  for (int r = 0; r < 3; ++r) {
    rows += "[";
    for (int c = 0; c < 3; ++c) rows += std::to_string(camera.rotation[3 * c + r]) + ", ";
    rows += std::to_string(centre[r]) + "], ";
  }
  return "[" + rows + "[0, 0, 0, 1]]";
}

FuzzedReader Vhap() {
  FuzzedReader reader{"vhap",
                      Placing::kFiles,
                      {"transforms_train.json", "transforms_test.json"},
                      ReadSequence,
                      [] {
                        const std::string t =
                            TransformsOf("0", MatrixOf({}), R"("flame_param_path": "0.npz")");
                        return Strings{JoinParts({t, t}), t};
                      },
                      {"flame_param_path", "transform_matrix", "0.npz", "null", "NaN", "1e999"}};
  reader.prepare = [](const std::string& folder) {
    FlameParamOf(SomeFrames(1, 2, 1), {0.5f}, 2, 3).Write(folder + "/0.npz");
  };
  return reader;
}

void WriteCheckpoints(const std::string& folder) {
  const Metrical metrical(2);
  MakeDirectories(folder + "/checkpoint");
  for (const auto& [i, values] : metrical.frames)
    WriteFileAtomically(folder + "/checkpoint/" + FrameName(i) + ".frame",
                        TorchArchive(MetricalPickle(values)));
}

Strings InstaSeeds() {
  const TemporaryFolder folder;
  WriteCheckpoints(folder.path());
  Strings parts;
  for (const int i : {0, 1}) {
    FlameParams params;
    Camera camera;
    ReadMetricalFrame(folder / ("checkpoint/" + FrameName(i) + ".frame"), params, camera);
    parts.push_back(
        TransformsOf(FrameName(i), MatrixOf(camera), R"("exp_path": "flame/exp/00000.txt")"));
  }
  return {JoinParts(parts), parts[0]};
}

FuzzedReader Insta() {
  return {"insta",
          Placing::kFiles,
          {"transforms_train.json", "transforms_test.json"},
          ReadSequence,
          InstaSeeds,
          {"exp_path", "seg_mask_path", "transform_matrix", "00001.png", "null"},
          WriteCheckpoints};
}

Strings DrivingSeeds() {
  Strings seeds = NpzSeeds(FlameParamOf(SomeFrames(3, 2, 1), {0.5f}, 2, 3));
  Npz npz("drive.npz");
  npz.Add("expr", {2, 3}, std::vector<float>(6, 0.5f));
  npz.Add("rot", {2, 3}, std::vector<float>(6, 0.1f));
  npz.Add("jaw_rot", {2, 3}, std::vector<float>(6, 0.1f));
  npz.Add("fps", {}, std::vector<float>{25});
  seeds.push_back(NpzSeeds(npz)[0]);
  Npz smirk("drive.npz");
  smirk.Add("expression_params", {2, 3}, std::vector<float>(6, 0.5f));
  smirk.Add("shape_params", {2, 2}, std::vector<float>(4, 0.5f));
  smirk.Add("pose_params", {2, 3}, std::vector<float>(6, 0.1f));
  smirk.Add("jaw_params", {2, 3}, std::vector<float>(6, 0.1f));
  smirk.Add("eyelid_params", {2, 2}, std::vector<float>(4, 0.1f));
  smirk.Add("cam", {2, 3}, std::vector<float>{7, 0, 0, 7, 0, 0});
  smirk.Add("image_size", {2}, std::vector<int32_t>{300, 400});
  seeds.push_back(NpzSeeds(smirk)[0]);
  return seeds;
}

Strings LandmarkSeeds() {
  const TemporaryFolder folder;
  LandmarkVideo video;
  video.source = "me.mp4";
  video.width = 64, video.height = 48;
  video.frames_per_second = 25;
  video.set = LandmarkSet::kOther;
  for (int f = 0; f < 3; ++f) {
    LandmarkFrame frame{std::to_string(f), f, {}, ""};
    for (int face = 0; face < f; ++face)
      frame.faces.push_back({{{1, 2}, {3.5, 4}}, 0.75, {{"jawOpen", 0.5f}}});
    video.frames.push_back(frame);
  }
  WriteLandmarks(folder / "marks.json", video);
  return {Slurped(folder / "marks.json")};
}

std::string ReadMarks(const std::string& folder, const std::string&) {
  const LandmarkVideo video = ReadLandmarks(folder + "/marks.json");
  for (const LandmarkFrame& frame : video.frames)
    for (const DetectedFace& face : frame.faces)
      for (const auto& point : face.points)
        if (const std::string problem = NotFinite(point); !problem.empty()) return problem;
  for (const ScoredFrame& frame : LoadScores(folder + "/marks.json").frames)
    for (const auto& [name, score] : frame.scores)
      if (!std::isfinite(score)) return "a score that is not finite";
  return "";
}

FlameModel SmallModel() { return RandomModel(6, 1, 2); }
constexpr int kEmbeddedPoints = 5;

Npz Embedding() {
  Npz npz("e.npz");
  npz.Add("lmk_face_idx", {2}, std::vector<int32_t>{0, 1});
  npz.Add("lmk_b_coords", {2, 3}, std::vector<float>{0.5f, 0.25f, 0.25f, 1, 0, 0});
  npz.Add("landmark_indices", {2}, std::vector<int32_t>{1, 4});
  return npz;
}

std::string ReadEmbedding(const std::string& folder, const std::string&) {
  const FlameModel model = SmallModel();
  ReadLandmarkEmbedding(folder + "/e.npz", model, kEmbeddedPoints);
  return "";
}

// Avatars.

FuzzedReader BoundPly() {
  FuzzedReader reader{"bound_ply", Placing::kFiles, {"point_cloud.ply"}, nullptr, nullptr, {}};
  reader.read = [](const std::string& folder, const std::string&) -> std::string {
    const std::string ply = folder + "/point_cloud.ply";
    if (!IsGaussianAvatarPly(ply)) return "";
    SummarizeGaussianAvatar(ply);
    const AvatarModel model = ReadGaussianAvatar(ply, SmallModel());
    for (const auto& values : model.gaussians.values)
      if (const std::string problem = NotFinite(values); !problem.empty()) return problem;
    for (const int32_t triangle : model.embedding.triangle)
      if (triangle < 0 || size_t(triangle) >= model.mesh.faces.size()) return "no such triangle";
    return "";
  };
  reader.seeds = [] {
    const TemporaryFolder folder;
    WriteBoundPly(folder / "a.ply", RandomRows(3, SmallModel().faces.size(), 1, 1));
    return Strings{Slurped(folder / "a.ply")};
  };
  reader.words = {
      "property float binding_0\n", "element vertex 3\n", "f_rest_44", "nan", "end_header\n"};
  reader.prepare = [](const std::string& folder) {
    const FlameModel model = SmallModel();
    FlameParamOf(SomeFrames(3, size_t(model.expression_count), 1),
                 std::vector<float>(size_t(model.shape_count), 0.3f),
                 size_t(model.expression_count),
                 size_t(model.vertex_count))
        .Write(folder + "/flame_param.npz");
  };
  return reader;
}

AvatarModel SmallAvatar() {
  AvatarModel model = RandomAvatar(SphereMesh(0, 0.1f), 3, 3);
  model.gaussians = RandomGaussians(3, 1, Basis::kSh, 4);
  BlendshapeMap& map = model.blendshapes.emplace();
  map.names = {"jawOpen", "other"};
  map.min = {0, 0.1f};
  map.max = {1, 0.4f};
  map.offset.assign(11, 0.1f);
  map.matrix.assign(22, 0.2f);
  return model;
}

std::string AvatarGlb() {
  const TemporaryFolder folder;
  WriteAvatarGlb(folder / "a.glb", SmallAvatar(), nullptr, {true, false});
  return Slurped(folder / "a.glb");
}

Strings AvatarChunks() {
  Strings seeds;
  for (const std::string& file :
       {AvatarGlb(), Slurped(COSPLAT_SOURCE_DIR "/tests/golden/avatar_v1.glb")}) {
    const GlbBytes parts = SplitGlb(file);
    seeds.push_back(JoinParts({parts.json.dump(), parts.binary}));
  }
  return seeds;
}

std::string ReadAvatar(const std::string& folder, const std::string&) {
  const AvatarModel model = ReadAvatarGlb(folder + "/a.glb");
  SummarizeGlb(folder + "/a.glb");
  for (const auto& values : model.gaussians.values)
    if (const std::string problem = NotFinite(values); !problem.empty()) return problem;
  for (const int32_t triangle : model.embedding.triangle)
    if (triangle < 0) return "a triangle below 0";
  return model.embedding.triangle.size() == model.gaussians.size() ? "" : "Gaussians without place";
}

}  // namespace

std::vector<FuzzedReader> HeadReaders() {
  const Strings pickle = {"cnumpy.core.multiarray\n_reconstruct\n",
                          "cnumpy\nndarray\n",
                          "ctorch._utils\n_rebuild_tensor_v2\n",
                          "R",
                          "b",
                          "(",
                          "t",
                          "}",
                          "\x80\x02",
                          "cos\nsystem\n",
                          "shapedirs",
                          "archive/data.pkl",
                          "archive/data/0"};
  const Strings binding = {"COSPLAT_mesh_binding",
                           "KHR_gaussian_splatting",
                           "triangle",
                           "barycentric",
                           "blendshapes",
                           "trainedRange",
                           "corrections",
                           "light",
                           "bust",
                           "version",
                           "accessors",
                           "byteOffset",
                           "componentType"};
  const auto zip = Placing::kZip;
  const auto files = Placing::kFiles;
  return {
      {"npz",
       files,
       {"a.npz"},
       ReadAnyNpz,
       [] {
         const TemporaryFolder folder;
         SomeArrays().Write(folder / "a.npz");
         return Strings{Slurped(folder / "a.npz")};
       },
       {"PK\1\2", "PK\3\4", "PK\5\6"}},
      {"npz_members",
       zip,
       {"a.npz"},
       ReadAnyNpz,
       [] { return NpzSeeds(SomeArrays()); },
       NpyWords()},
      {"flame_npz",
       zip,
       {"m.npz"},
       [](const std::string& folder, const std::string&) {
         return ModelProblem(LoadFlameModel(folder + "/m.npz"));
       },
       FlameNpzSeeds,
       NpyWords()},
      {"flame_pickle",
       files,
       {"m.pkl"},
       [](const std::string& folder, const std::string&) {
         return ModelProblem(LoadFlameModel(folder + "/m.pkl"));
       },
       PickleSeeds,
       pickle},
      {"pickle", files, {}, ReadAnyPickle, PickleAlone, pickle},
      {"torch", zip, {"00000.frame"}, ReadTorch, TorchSeeds, pickle},
      {"imavatar",
       files,
       {"flame_params.json"},
       ReadSequence,
       ImavatarSeeds,
       {"intrinsics", "world_mat", "expression", "eyelids", "shape_params", "null", "1e999"}},
      Vhap(),
      Insta(),
      {"driving_npz", zip, {"drive.npz"}, ReadDrivingNpz, DrivingSeeds, NpyWords()},
      {"landmarks",
       files,
       {"marks.json"},
       ReadMarks,
       LandmarkSeeds,
       {"mediapipe-478", "ibug-68", "other", "blendshapes", "points", "score", "matte", "1e999"}},
      {"landmark_embedding",
       zip,
       {"e.npz"},
       ReadEmbedding,
       [] { return NpzSeeds(Embedding()); },
       NpyWords()},
      BoundPly(),
      {"avatar_glb", files, {"a.glb"}, ReadAvatar, [] { return Strings{AvatarGlb()}; }, binding},
      {"avatar_glb_chunks", Placing::kGlb, {"a.glb"}, ReadAvatar, AvatarChunks, binding}};
}

}  // namespace cosplat::test
