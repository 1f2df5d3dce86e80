#include <algorithm>
#include <cmath>
#include <filesystem>

#include "flame/blendshape_names.h"
#include "flame/io/pickle.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr size_t kShapeDirectionsInFlame = 300;
constexpr int kMediapipePoints = 478;

// What people have in place of a model.
void CheckContent(const std::string& path,
                  const std::string& extension,
                  const std::vector<char>& bytes) {
  const std::string_view begin(bytes.data(), std::min<size_t>(bytes.size(), 64));
  const std::string other = OtherContent(begin);
  if (!other.empty()) throw Error(path, other);
  if (extension != ".npz" && begin.starts_with("PK"))
    throw Error(path, "is a ZIP archive: unpack it, the model is the .pkl in it");
  // A pickle of protocol 2 and up begins with 0x80 and has lone line feeds among its numbers.
  if (extension == ".pkl" && begin.starts_with("\x80") && bytes.size() > 4096) {
    size_t feeds = 0, after_return = 0;
    for (size_t i = 1; i < bytes.size(); ++i)
      if (bytes[i] == '\n') ++feeds, after_return += bytes[i - 1] == '\r';
    if (feeds > 0 && feeds == after_return)
      throw Error(path,
                  "was changed on its way: every line feed has a carriage return before it; "
                  "download it again as a binary file");
  }
}

Npz ReadPickle(const std::string& path, const std::vector<char>& bytes) {
  const Pickle pickle(path, bytes);
  if (pickle.root().kind != PickleValue::Kind::kDict)
    throw Error(path, "is not a FLAME model: its pickle does not contain a dictionary");
  Npz arrays(path);
  for (const char* name :
       {"v_template", "f", "shapedirs", "posedirs", "J_regressor", "weights", "kintree_table"})
    if (const PickleValue* value = pickle.root().Find(name))
      arrays.Add(name, ArrayOf(path, name, *value));
  return arrays;
}

// The arrays of a model file by name, for both file formats.
Npz ReadArrays(const std::string& path, const std::vector<char>& bytes) {
  const std::string extension = LowerCase(std::filesystem::path(path).extension().string());
  CheckContent(path, extension, bytes);
  if (extension == ".npz") return Npz::Parse(path, bytes);
  if (extension == ".pkl") return ReadPickle(path, bytes);
  throw Error(path, "is not a FLAME model: expected .pkl or .npz");
}

// The name of the array with this name, or of the only one with this prefix ("shapedirs60_open").
std::string NameOf(const Npz& arrays, const std::string& prefix) {
  if (arrays.Has(prefix)) return prefix;
  std::string name;
  for (const auto& [candidate, array] : arrays.arrays()) {
    if (!candidate.starts_with(prefix)) continue;
    if (!name.empty())
      throw Error(arrays.path(), name, "array is ambiguous: there is " + candidate + " too");
    name = candidate;
  }
  return name.empty() ? prefix : name;
}

// Element of an array as an integer in [low, high].
int IntegerAt(const Npz& arrays,
              const std::string& name,
              const NpyArray& array,
              size_t i,
              int low,
              int high) {
  const double x = array.values[i];
  if (!(x >= low && x <= high) || x != std::floor(x))
    throw Error(arrays.path(),
                name + "[" + std::to_string(i) + "]",
                Format("is {}, expected an integer from {} to {}", x, low, high));
  return int(x);
}

int Integer(const Npz& arrays, const std::string& name, int low, int high) {
  return IntegerAt(arrays, name, arrays.Get(name, {}), 0, low, high);
}

std::vector<float> ToFloats(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

// [V, 3, K] in the file -> [count, V, 3] from direction `first` on.
std::vector<float> DirectionsOf(const NpyArray& array, size_t first, size_t count) {
  const size_t rows = array.shape[0] * array.shape[1];
  const size_t columns = array.shape[2];
  std::vector<float> out(count * rows);
  for (size_t r = 0; r < rows; ++r)
    for (size_t k = 0; k < count; ++k)
      out[k * rows + r] = float(array.values[r * columns + first + k]);
  return out;
}

void DropTrailingZeroDirections(std::vector<float>& directions, size_t rows) {
  const auto last =
      std::find_if(directions.rbegin(), directions.rend(), [](float x) { return x != 0; });
  const size_t used = size_t(directions.rend() - last);  // count up to the last non-zero number
  directions.resize((used + rows - 1) / rows * rows);
  directions.shrink_to_fit();
}

void ReadShapeDirections(const Npz& arrays, FlameModel& model) {
  const size_t v = model.vertex_count;
  const std::string name = NameOf(arrays, "shapedirs");
  const NpyArray& array = arrays.Get(name, {model.vertex_count, 3, -1});
  const size_t total = array.shape[2];
  size_t shapes = std::min(total, kShapeDirectionsInFlame);
  if (arrays.Has("n_shape") || arrays.Has("n_expr")) {
    shapes = Integer(arrays, "n_shape", 0, int(std::min<size_t>(total, 1 << 20)));
    const size_t expressions = Integer(arrays, "n_expr", 0, 1 << 20);
    if (shapes + expressions != total)
      throw Error(arrays.path(),
                  name,
                  Format("has shape [{}, 3, {}], but n_shape + n_expr = {} + {}",
                         v,
                         total,
                         shapes,
                         expressions));
  }
  model.shape_directions = DirectionsOf(array, 0, shapes);
  model.expression_directions = DirectionsOf(array, shapes, total - shapes);
  DropTrailingZeroDirections(model.shape_directions, 3 * v);
  DropTrailingZeroDirections(model.expression_directions, 3 * v);
  model.shape_count = int(model.shape_directions.size() / (3 * v));
  model.expression_count = int(model.expression_directions.size() / (3 * v));
}

void ReadFaces(const Npz& arrays, FlameModel& model) {
  const std::string name = arrays.Has("f") ? "f" : "faces";
  const NpyArray& array = arrays.Get(name, {-1, 3});
  model.faces.resize(array.shape[0]);
  for (size_t i = 0; i < array.size(); ++i)
    model.faces[i / 3][i % 3] = IntegerAt(arrays, name, array, i, 0, model.vertex_count - 1);
}

// kintree_table: row 0 holds the parents (-1 for the root, possibly as unsigned), row 1 the joints.
void ReadParents(const Npz& arrays, FlameModel& model) {
  const bool table = arrays.Has("kintree_table") || !arrays.Has("parents");
  const std::string name = table ? "kintree_table" : "parents";
  const NpyArray& array =
      table ? arrays.Get(name, {2, kFlameJoints}) : arrays.Get(name, {kFlameJoints});
  for (int j = 0; j < kFlameJoints; ++j) {
    const bool unsigned_root = array.values[j] >= 4294967295.0;
    model.parents[j] = unsigned_root ? -1 : IntegerAt(arrays, name, array, j, -1, kFlameJoints - 1);
    if (table) IntegerAt(arrays, name, array, kFlameJoints + j, j, j);
  }
}

void ReadLandmarks(const Npz& arrays, FlameModel& model) {
  if (!arrays.Has("landmark_vertices")) return;
  const NpyArray& indices = arrays.Get("landmark_indices", {-1});
  const size_t count = indices.size();
  const NpyArray& vertices = arrays.Get("landmark_vertices", {long(count), 3});
  const NpyArray& barycentric = arrays.Get("landmark_barycentric", {long(count), 3});
  const NpyArray& looseness = arrays.Get("landmark_looseness", {long(count)});
  for (size_t i = 0; i < count; ++i) {
    EmbeddedLandmark point;
    point.landmark = IntegerAt(arrays, "landmark_indices", indices, i, 0, kMediapipePoints - 1);
    for (size_t k = 0; k < 3; ++k) {
      point.vertices[k] =
          IntegerAt(arrays, "landmark_vertices", vertices, 3 * i + k, 0, model.vertex_count - 1);
      point.barycentric[k] = barycentric.values[3 * i + k];
    }
    point.looseness = looseness.values[i];
    model.landmarks.push_back(point);
  }
}

void AddLandmarks(const FlameModel& model, Npz& npz) {
  if (model.landmarks.empty()) return;
  std::vector<int32_t> indices, vertices;
  std::vector<float> barycentric, looseness;
  for (const EmbeddedLandmark& point : model.landmarks) {
    indices.push_back(point.landmark);
    vertices.insert(vertices.end(), point.vertices.begin(), point.vertices.end());
    barycentric.insert(barycentric.end(), point.barycentric.begin(), point.barycentric.end());
    looseness.push_back(float(point.looseness));
  }
  npz.Add("landmark_indices", {indices.size()}, indices);
  npz.Add("landmark_vertices", {indices.size(), 3}, vertices);
  npz.Add("landmark_barycentric", {indices.size(), 3}, barycentric);
  npz.Add("landmark_looseness", {indices.size()}, looseness);
}

constexpr const char *kBlendshapes = "expression_blendshapes", *kScores = "expression_scores";

void ReadExpressionNames(const Npz& arrays, FlameModel& model) {
  if (!arrays.Has(kBlendshapes)) return;
  const size_t count = size_t(model.expression_count);
  const NpyArray& indices = arrays.Get(kBlendshapes, {model.expression_count});
  for (size_t e = 0; e < count; ++e) {
    const int at = IntegerAt(arrays, kBlendshapes, indices, e, -1, int(kArkitBlendshapes) - 1);
    model.expression_names.emplace_back(at < 0 ? "" : kArkitNames[size_t(at)]);
  }
  model.expression_scores = ToFloats(arrays.Get(kScores, {model.expression_count}).values);
  model.has_eyelids = count >= 2 && model.expression_names[count - 2] == "eyeBlinkLeft" &&
                      model.expression_names[count - 1] == "eyeBlinkRight";
}

void AddExpressionNames(const FlameModel& model, Npz& npz) {
  if (model.expression_names.empty()) return;
  std::vector<int32_t> indices;
  for (const std::string& name : model.expression_names)
    indices.push_back(FindArkitBlendshape(name));
  npz.Add(kBlendshapes, {indices.size()}, indices);
  npz.Add(kScores, {indices.size()}, model.expression_scores);
}

// Sum over the template's triangles.
double TotalArea(const FlameModel& model) {
  double total = 0;
  for (const auto& face : model.faces) {
    const float *a = &model.template_vertices[3 * size_t(face[0])],
                *b = &model.template_vertices[3 * size_t(face[1])],
                *c = &model.template_vertices[3 * size_t(face[2])];
    double u[3], v[3];
    for (int k = 0; k < 3; ++k) {
      u[k] = double(b[k]) - a[k];
      v[k] = double(c[k]) - a[k];
    }
    total +=
        0.5 *
        std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return total;
}

void ConvertToMetres(FlameModel& model) {
  const double size = std::sqrt(TotalArea(model)) / kFlameTemplateSize;
  for (const double unit : {0.001, 0.01, 1000.0})
    if (std::abs(std::log(size * unit)) < std::log(3.0)) model.unit = unit;
  if (model.unit == 1) return;
  for (std::vector<float>* lengths : {&model.template_vertices,
                                      &model.shape_directions,
                                      &model.expression_directions,
                                      &model.pose_directions})
    for (float& x : *lengths) x = float(double(x) * model.unit);
}

}  // namespace

FlameModel LoadFlameModel(const std::string& path) { return ParseFlameModel(path, ReadFile(path)); }

FlameModel ParseFlameModel(const std::string& path, std::vector<char> bytes) {
  const Npz arrays = ReadArrays(path, bytes);
  FlameModel model;
  model.name = path;  // for Validate's errors
  const NpyArray& vertices = arrays.Get("v_template", {-1, 3});
  if (vertices.shape[0] == 0 || vertices.shape[0] > (1 << 24))
    throw Error(path, "v_template", Format("has shape [{}, 3]", vertices.shape[0]));
  const long v = long(vertices.shape[0]);
  model.vertex_count = int(v);
  model.template_vertices = ToFloats(vertices.values);
  ReadFaces(arrays, model);
  ReadShapeDirections(arrays, model);
  model.pose_directions = DirectionsOf(
      arrays.Get(NameOf(arrays, "posedirs"), {v, 3, kFlamePoseFeatures}), 0, kFlamePoseFeatures);
  model.joint_regressor = ToFloats(arrays.Get("J_regressor", {kFlameJoints, v}).values);
  model.skinning_weights = ToFloats(arrays.Get("weights", {v, kFlameJoints}).values);
  ReadParents(arrays, model);
  ReadLandmarks(arrays, model);
  ReadExpressionNames(arrays, model);
  model.redistributable =
      arrays.Has("redistributable") && Integer(arrays, "redistributable", 0, 1) == 1;
  ConvertToMetres(model);
  Validate(model);
  model.name = std::filesystem::path(path).filename().string();
  model.sha256 = Sha256(bytes.data(), bytes.size());
  if (model.redistributable) model.file = std::move(bytes);
  return model;
}

void WriteFlameModelNpz(const std::string& path, const FlameModel& model) {
  Validate(model);
  const size_t v = model.vertex_count;
  // [K, V, 3] -> [V, 3, K], shape then expression.
  const auto interleave = [&](const std::vector<const std::vector<float>*>& groups,
                              size_t columns) {
    std::vector<float> out(3 * v * columns);
    size_t k = 0;
    for (const std::vector<float>* group : groups)
      for (size_t begin = 0; begin < group->size(); begin += 3 * v, ++k)
        for (size_t r = 0; r < 3 * v; ++r) out[r * columns + k] = (*group)[begin + r];
    return out;
  };
  const size_t directions = model.shape_count + model.expression_count;
  std::vector<int32_t> faces;
  for (const auto& face : model.faces) faces.insert(faces.end(), face.begin(), face.end());
  std::vector<int32_t> tree(model.parents.begin(), model.parents.end());
  for (int j = 0; j < kFlameJoints; ++j) tree.push_back(j);

  Npz npz;
  npz.Add("v_template", {v, 3}, model.template_vertices);
  npz.Add("f", {model.faces.size(), 3}, faces);
  npz.Add("shapedirs",
          {v, 3, directions},
          interleave({&model.shape_directions, &model.expression_directions}, directions));
  npz.Add("n_shape", {}, std::vector<int32_t>{model.shape_count});
  npz.Add("n_expr", {}, std::vector<int32_t>{model.expression_count});
  npz.Add("posedirs",
          {v, 3, kFlamePoseFeatures},
          interleave({&model.pose_directions}, kFlamePoseFeatures));
  npz.Add("J_regressor", {kFlameJoints, v}, model.joint_regressor);
  npz.Add("weights", {v, kFlameJoints}, model.skinning_weights);
  npz.Add("kintree_table", {2, kFlameJoints}, tree);
  AddLandmarks(model, npz);
  AddExpressionNames(model, npz);
  npz.Add("redistributable", {}, std::vector<int32_t>{model.redistributable ? 1 : 0});
  npz.Write(path);
}

}  // namespace cosplat
