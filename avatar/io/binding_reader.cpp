#include <algorithm>
#include <cmath>
#include <limits>

#include "avatar/io/binding_extension.h"
#include "avatar/math/correct.h"
#include "avatar/model/corrections.h"
#include "flame/eyelids.h"
#include "flame/mouth.h"
#include "flame/vhap_teeth.h"
#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/io/splat_primitive.h"

namespace cosplat {
namespace {

constexpr int kMaxCount = std::numeric_limits<int32_t>::max();
constexpr float kMaxFilmed = 3.15f;                // radians
constexpr double kMinUnit = 1e-9, kMaxUnit = 1e9;  // metres: allows any head in any unit

void CheckCount(const JsonField& field, size_t found, size_t expected) {
  if (found != expected)
    field.Fail(Format("accessor has {} elements, expected {}", found, expected));
}

// Reads the accessor that `field` refers to. expected: its number of elements, 0 for any.
std::vector<float> Floats(const GlbDocument& document,
                          const JsonField& field,
                          int width,
                          size_t expected) {
  auto values = ReadValues<float>(document, field.Integer(), width, field.path());
  if (expected > 0) CheckCount(field, values.size() / width, expected);
  return values;
}

void FillFloats(const GlbDocument& document,
                const JsonField& field,
                AvatarModel& model,
                Attribute attribute) {
  const int width = model.gaussians.width(attribute);
  const auto values = Floats(document, field, width, model.embedding.triangle.size());
  model.gaussians.values[attribute].assign(values.begin(), values.end());
}

template <size_t kCount>
void FillNumbers(const JsonField& field, std::array<float, kCount>& out) {
  const std::vector<float> numbers = field.Numbers(kCount);
  std::copy(numbers.begin(), numbers.end(), out.begin());
}

void ReadRule(const JsonField& rule, Embedding& embedding) {
  const std::string name = rule["name"].String();
  embedding.rigid = name == kRigidRule;
  if (embedding.rigid) return;
  if (name != kReleasedRule)
    rule["name"].Fail("is '" + name + "', expected " + kReleasedRule + " or " + kRigidRule);
  const double unit = rule["unit"].Number();
  if (!(unit >= kMinUnit && unit <= kMaxUnit))
    rule["unit"].Fail("is " + rule["unit"].raw().dump() + ", expected metres, 1e-9 to 1e9");
  embedding.released = ReleasedRule{float(unit)};
}

// Fields added in version 2. A file of version 1 may use these names for anything.
void ReadVersion2(const JsonField& binding, AvatarModel& model) {
  if (binding.Has("rule")) ReadRule(binding["rule"], model.embedding);
  if (!binding.Has("canonicalFrame")) return;
  const JsonField field = binding["canonicalFrame"];
  FlameParams& frame = model.canonical_frame.emplace();
  frame.expression = field["expression"].Numbers();
  const std::vector<float> pose = field["pose"].Numbers(3 * kFlameJoints);
  for (size_t i = 0; i < pose.size(); ++i) frame.pose[i / 3][i % 3] = pose[i];
  FillNumbers(field["translation"], frame.translation);
}

// Checks that an array is at least as large as another, number by number.
void CheckRange(const JsonField& field, View<const float> min, View<const float> max) {
  if (max.size() != min.size())
    field.Fail(Format("has {} numbers, expected {}", max.size(), min.size()));
  for (size_t i = 0; i < min.size(); ++i)
    if (min[i] > max[i]) field[i].Fail(Format("is {}, below the minimum {}", max[i], min[i]));
}

void ReadBustFollow(const JsonField& field, BustFollow& follow) {
  FillNumbers(field["headMean"], follow.head_mean);
  FillNumbers(field["matrix"], follow.matrix);
  FillNumbers(field["mean"], follow.mean);
  FillNumbers(field["least"], follow.min);
  FillNumbers(field["most"], follow.max);
  CheckRange(field["most"], follow.min, follow.max);
}

// Bases of N Gaussians in steps: 14 numbers of a basis have a step each.
Buffer<float> ReadSteps(const GlbDocument& document, const JsonField& field, size_t expected) {
  const std::vector<float> step = field["step"].Numbers(math::kCorrectionWidth);
  const std::vector<int16_t> steps =
      ReadValues<int16_t>(document, field["bases"].Integer(), 1, field["bases"].path());
  CheckCount(field["bases"], steps.size(), expected);
  Buffer<float> bases(expected);
  for (size_t i = 0; i < expected; ++i) {
    const size_t k = i % step.size();
    bases[i] = float(steps[i]) * step[k];
    if (!std::isfinite(bases[i])) field["step"][k].Fail(Format("is {}, too large", step[k]));
  }
  return bases;
}

// After the embedding has been read.
void ReadCorrections(const GlbDocument& document, const JsonField& field, AvatarModel& model) {
  CorrectionMap& map = model.correction_map;
  model.gaussians.corrections = field["count"].Integer(1, kMaxCorrections);
  const size_t count = size_t(model.gaussians.corrections);
  map.mean = field["mean"].Numbers();
  map.matrix = field["matrix"].Numbers(count * map.mean.size());
  map.min = field["least"].Numbers(count);
  map.max = field["most"].Numbers(count);
  CheckRange(field["most"], map.min, map.max);
  if (map.mean.size() < kMinCorrectionInputs)
    field["mean"].Fail("has " + std::to_string(map.mean.size()) + " numbers, expected at least " +
                       std::to_string(kMinCorrectionInputs));
  const size_t expected =
      size_t(model.gaussians.width(kCorrection)) * model.embedding.triangle.size();
  Buffer<float>& bases = model.gaussians.values[kCorrection];
  if (field.Has("step"))  // since version 4
    bases = ReadSteps(document, field, expected);
  else
    bases = Buffer<float>(Floats(document, field["bases"], 1, expected));
}

void ReadLight(const JsonField& field, AvatarModel& model) {
  Light& light = model.light.emplace();
  FillNumbers(field, light);
  for (size_t k = 0; k < light.size(); ++k)
    if (std::abs(light[k]) > math::kMaxLight)
      field[k].Fail("is " + std::to_string(light[k]) + ", expected -5 to 5");
}

void ReadTrainedRange(const JsonField& field, AvatarModel& model) {
  TrainedRange& range = model.trained_range.emplace();
  range.expression_least = field["expressionLeast"].Numbers();
  range.expression_most = field["expressionMost"].Numbers();
  CheckRange(field["expressionMost"], range.expression_least, range.expression_most);
  FillNumbers(field["angle"], range.angle);
}

void ReadFilmed(const JsonField& field, AvatarModel& model) {
  FilmedFrom& filmed = model.filmed.emplace();
  FillNumbers(field["yaw"], filmed.yaw);
  FillNumbers(field["pitch"], filmed.pitch);
  for (const auto& [name, range] : {std::pair("yaw", filmed.yaw), std::pair("pitch", filmed.pitch)})
    if (!(range[0] <= range[1] && -kMaxFilmed <= range[0] && range[1] <= kMaxFilmed))
      field[name].Fail("is no range of angles");
  if (!field.Has("guessed")) return;
  filmed.guessed = float(field["guessed"].Number());
  if (!(*filmed.guessed >= 0 && *filmed.guessed <= 1))
    field["guessed"].Fail("is no share from 0 to 1");
}

void ReadBlendshapes(const GlbDocument& document, const JsonField& field, AvatarModel& model) {
  BlendshapeMap& map = model.blendshapes.emplace();
  const JsonField names = field["names"], fit = field["fit"];
  if (names.size() == 0 || names.size() > kMaxBlendshapes)
    names.Fail(Format("has {} names, expected 1 to {}", names.size(), kMaxBlendshapes));
  for (size_t i = 0; i < names.size(); ++i) map.names.push_back(names[i].String());
  map.min = field["least"].Numbers(names.size());
  map.max = field["most"].Numbers(names.size());
  map.offset = field["offset"].Numbers();
  map.matrix = Floats(document, field["matrix"], 1, names.size() * map.offset.size());
  map.fit.frames = fit["frames"].Integer(0, kMaxCount);
  map.fit.r2 = float(fit["r2"].Number());
  map.fit.error = float(fit["error"].Number());
  map.fit.mean_face_error = float(fit["meanFaceError"].Number());
  if (const std::string problem = ProblemOf(map); !problem.empty()) field.Fail(problem);
}

// Reads all fields of the binding that are not accessors.
void ReadHeader(const JsonField& binding, AvatarModel& model) {
  const int version = binding["version"].Integer(1, kBindingVersion);
  if (version >= 2) ReadVersion2(binding, model);
  model.gaussians.degree = binding["degree"].Integer(0, kMaxTrainedDegree);
  const std::string basis = binding["basis"].String(), frame = binding["colorFrame"].String();
  model.gaussians.basis = BasisFromString(basis, binding.file(), binding["basis"].path());
  if (frame != ToString(ColorFrame::kSurface) && frame != ToString(ColorFrame::kWorld))
    binding["colorFrame"].Fail("is '" + frame + "', expected surface or world");
  model.color_frame =
      frame == ToString(ColorFrame::kWorld) ? ColorFrame::kWorld : ColorFrame::kSurface;
  model.flame_name = binding["flame"]["name"].String();
  model.flame_sha256 = binding["flame"]["sha256"].String();
  // A geometry that is not known here cannot be played. 0: none.
  const auto geometry = [&](const char* addition, int min, int max) {
    const JsonField flame = binding["flame"];
    return version < 3 || !flame.Has(addition) ? 0 : flame[addition].Integer(min, max);
  };
  static_assert(kVhapTeethGeometry == kMouthGeometry + 1);
  const int mouth = geometry("mouth", kMouthGeometry, kVhapTeethGeometry);
  model.has_mouth = mouth == kMouthGeometry;
  model.has_vhap_teeth = mouth == kVhapTeethGeometry;
  model.has_eyelids = geometry("eyelids", kEyelidGeometry, kEyelidGeometry) != 0;
  FillNumbers(binding["background"], model.background);
  if (binding.Has("trainedRange")) ReadTrainedRange(binding["trainedRange"], model);
  if (binding.Has("filmed")) ReadFilmed(binding["filmed"], model);
  if (!binding.Has("bust")) return;
  model.bust.emplace();
  FillNumbers(binding["bust"]["rotation"], model.bust->rotation);
  FillNumbers(binding["bust"]["translation"], model.bust->translation);
  if (version >= 3 && binding["bust"].Has("follow"))
    ReadBustFollow(binding["bust"]["follow"], model.bust->follow.emplace());
}

Buffer<int32_t> ReadTriangles(const GlbDocument& document,
                              const JsonField& field,
                              size_t face_count) {
  const auto indices = ReadValues<uint32_t>(document, field.Integer(), 1, field.path());
  for (size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= face_count)
      field.Fail("Gaussian " + std::to_string(i) + " is on face " + std::to_string(indices[i]) +
                 ", but the mesh has " + std::to_string(face_count) + " faces");
  return {indices.begin(), indices.end()};
}

void ReadColorRest(const GlbDocument& document, const JsonField& binding, AvatarModel& model) {
  const int rest = CoefficientCount(model.gaussians.degree) - 1;
  if (rest == 0) return;
  const JsonField accessors = binding["colorRest"];
  if (accessors.size() != size_t(rest))
    accessors.Fail(Format("has {} accessors, expected {}", accessors.size(), rest));
  model.gaussians.values[kColorRest].resize(3 * rest * model.size());
  for (int k = 0; k < rest; ++k) {
    const auto values = Floats(document, accessors[k], 3, model.size());
    for (size_t i = 0; i < model.size(); ++i)
      std::copy_n(&values[3 * i], 3, model.gaussians.at(kColorRest, i) + 3 * k);
  }
}

const GlbPrimitive& MeshPrimitive(const GlbDocument& document, const JsonField& field) {
  const int index = field.Integer(0, kMaxCount);
  if (size_t(index) >= document.meshes.size())
    field.Fail("refers to mesh " + std::to_string(index) + ", but the file has " +
               std::to_string(document.meshes.size()) + " meshes");
  const auto& primitives = document.meshes[index].primitives;
  if (primitives.size() != 1 || primitives[0].mode != kGlbTriangles ||
      !primitives[0].attributes.contains("POSITION"))
    field.Fail("refers to a mesh that is not a single triangle primitive with positions");
  return primitives[0];
}

void ReadMesh(const GlbDocument& document,
              const JsonField& field,
              size_t vertex_count,
              size_t face_count,
              CanonicalMesh& mesh) {
  if (!field.Has("mesh")) return;
  const JsonField index = field["mesh"];
  const GlbPrimitive& primitive = MeshPrimitive(document, index);
  mesh.vertices = ReadValues<float>(
      document, primitive.attributes.at("POSITION"), 3, index.path() + ".POSITION");
  const auto indices =
      ReadValues<uint32_t>(document, primitive.indices, 1, index.path() + ".indices");
  CheckCount(index, mesh.vertices.size() / 3, vertex_count);
  CheckCount(index, indices.size(), 3 * face_count);
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= vertex_count)
      index.Fail("face " + std::to_string(i / 3) + " refers to vertex " +
                 std::to_string(indices[i]) + ", but there are " + std::to_string(vertex_count) +
                 " vertices");
    if (i % 3 == 0) mesh.faces.emplace_back();
    mesh.faces.back()[i % 3] = int32_t(indices[i]);
  }
}

// Wrapped, so that errors show the full path of its fields.
JsonField Named(const GlbDocument& document, const Json& binding) {
  return JsonField(document.path, Json{{kBindingExtension, binding}})[kBindingExtension];
}

}  // namespace

Json FindBinding(const GlbPrimitive& splats) {
  const Json& extension = splats.extensions[kSplatExtension];
  if (!extension.is_object() || !extension.contains("extensions")) return {};
  const Json& children = extension["extensions"];
  return children.is_object() ? children.value(kBindingExtension, Json()) : Json();
}

AvatarModel ReadBinding(const GlbDocument& document, const Json& json) {
  const JsonField binding = Named(document, json);
  AvatarModel model;
  ReadHeader(binding, model);
  const JsonField mesh = binding["canonicalMesh"];
  const size_t vertex_count = mesh["vertexCount"].Integer(1, kMaxCount);
  const size_t face_count = mesh["faceCount"].Integer(1, kMaxCount);
  ReadMesh(document, mesh, vertex_count, face_count, model.mesh);
  model.embedding.triangle = ReadTriangles(document, binding["triangle"], face_count);
  const size_t n = model.embedding.triangle.size();
  const auto barycentric = Floats(document, binding["barycentric"], 2, n);
  for (size_t i = 0; i < n; ++i)
    model.embedding.barycentric.push_back({barycentric[2 * i], barycentric[2 * i + 1]});
  FillFloats(document, binding["offset"], model, kPosition);
  FillFloats(document, binding["rotation"], model, kRotation);
  FillFloats(document, binding["scaleLog"], model, kScaleLog);
  FillFloats(document, binding["opacityLogit"], model, kOpacityLogit);
  FillFloats(document, binding["colorDc"], model, kColorDc);
  ReadColorRest(document, binding, model);
  if (binding["version"].Integer() >= 3 && binding.Has("corrections"))
    ReadCorrections(document, binding["corrections"], model);
  if (binding["version"].Integer() >= 4 && binding.Has("light")) ReadLight(binding["light"], model);
  if (binding.Has("blendshapes")) ReadBlendshapes(document, binding["blendshapes"], model);
  if (const JsonField flame = binding["flame"]; flame.Has("file"))
    model.flame_file = ReadValues<char>(document, flame["file"].Integer(), 1, flame["file"].path());
  if (binding.Has("shape")) model.shape = Floats(document, binding["shape"], 1, 0);
  if (binding.Has("staticOffset")) {
    const JsonField field = binding["staticOffset"];
    model.static_offset = Floats(document, field, 3, model.bust ? 0 : vertex_count);
    if (model.static_offset.size() / 3 > vertex_count)  // with a bust, FLAME has fewer vertices
      field.Fail("accessor has " + std::to_string(model.static_offset.size() / 3) +
                 " elements for " + std::to_string(vertex_count) + " vertices");
  }
  return model;
}

GlbSummary::Avatar SummarizeBinding(const GlbDocument& document, const Json& json) {
  GlbSummary::Avatar summary;
  summary.model = ReadBinding(document, json);
  summary.version = json["version"].get<int>();  // checked by ReadBinding
  const Json& mesh = json["canonicalMesh"];
  summary.vertex_count = mesh["vertexCount"].get<size_t>();
  summary.face_count = mesh["faceCount"].get<size_t>();
  if (mesh.contains("mesh"))
    summary.expression_count =
        document.meshes[mesh["mesh"].get<size_t>()].primitives[0].targets.size();
  return summary;
}

}  // namespace cosplat
