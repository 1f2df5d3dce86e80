#include "avatar/io/avatar_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "avatar/io/binding_extension.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/model/corrections.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/surface.h"
#include "splat/base/error.h"
#include "splat/base/median.h"
#include "splat/base/text.h"
#include "splat/io/glb.h"
#include "splat/io/splat_primitive.h"

namespace cosplat {
namespace {

void CheckArray(const std::string& path,
                const std::string& name,
                View<const float> values,
                size_t expected) {
  if (values.size() != expected)
    throw Error(path, name, Format("has {} numbers, expected {}", values.size(), expected));
  for (size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(path, name, Format("number {} is not finite ({})", i, values[i]));
}

void CheckOptionalParts(const std::string& path, const AvatarModel& model) {
  if (model.bust) {
    CheckArray(path, "bust rotation", model.bust->rotation, 9);
    CheckArray(path, "bust translation", model.bust->translation, 3);
    if (const auto& follow = model.bust->follow) {
      CheckArray(path, "bust follow headMean", follow->head_mean, 9);
      CheckArray(path, "bust follow matrix", follow->matrix, 54);
      CheckArray(path, "bust follow mean", follow->mean, 6);
      CheckArray(path, "bust follow least", follow->min, 6);
      CheckArray(path, "bust follow most", follow->max, 6);
    }
  }
  if (model.gaussians.corrections > 0) {
    const CorrectionMap& map = model.correction_map;
    const size_t count = size_t(model.gaussians.corrections);
    CheckArray(path, "corrections mean", map.mean, map.mean.size());
    CheckArray(path, "corrections matrix", map.matrix, count * map.mean.size());
    CheckArray(path, "corrections least", map.min, count);
    CheckArray(path, "corrections most", map.max, count);
  }
  if (model.light) {
    CheckArray(path, "light", *model.light, model.light->size());
    for (const float l : *model.light)
      if (std::abs(l) > math::kMaxLight)
        throw Error(path, "light", "holds " + std::to_string(l) + ", expected -5 to 5");
  }
  if (const auto& filmed = model.filmed) {
    CheckArray(path, "filmed yaw", filmed->yaw, 2);
    CheckArray(path, "filmed pitch", filmed->pitch, 2);
  }
  if (const auto& range = model.trained_range) {
    CheckArray(path, "trained least", range->expression_least, range->expression_least.size());
    CheckArray(path, "trained most", range->expression_most, range->expression_least.size());
    CheckArray(path, "trained angle", range->angle, kFlameJoints);
  }
  if (model.blendshapes)
    if (const std::string problem = ProblemOf(*model.blendshapes); !problem.empty())
      throw Error(path, "blendshapes", problem);
  if (model.embedding.released &&
      !(model.embedding.released->unit > 0 && std::isfinite(model.embedding.released->unit)))
    throw Error(path, "rule unit", "is " + std::to_string(model.embedding.released->unit));
  if (model.canonical_frame) {
    const FlameParams& frame = *model.canonical_frame;
    CheckArray(path, "canonical expression", frame.expression, frame.expression.size());
    for (const auto& joint : frame.pose) CheckArray(path, "canonical pose", joint, 3);
    CheckArray(path, "canonical translation", frame.translation, 3);
  }
}

void CheckModel(const std::string& path, const AvatarModel& model) {
  constexpr std::array<const char*, kAttributeCount> kNames{
      "offset", "rotation", "scale_log", "opacity_logit", "color_dc", "color_rest", "correction"};
  const size_t n = model.size();
  const int degree = model.gaussians.degree;
  if (degree < 0 || degree > kMaxTrainedDegree)
    throw Error(path, "degree", "is " + std::to_string(degree) + ", expected 0 to 4");
  for (int a = 0; a < kAttributeCount; ++a)
    CheckArray(path, kNames[a], model.gaussians.values[a], n * model.gaussians.width(a));
  if (model.embedding.triangle.size() != n || model.embedding.barycentric.size() != n)
    throw Error(path,
                "triangle, barycentric",
                "have " + std::to_string(model.embedding.triangle.size()) + " and " +
                    std::to_string(model.embedding.barycentric.size()) + " elements, expected " +
                    std::to_string(n));
  for (const auto& uv : model.embedding.barycentric) CheckArray(path, "barycentric", uv, 2);
  if (model.mesh.faces.empty())
    throw Error(path, "mesh", "is empty: attach it from the FLAME model first");
  CheckArray(path, "shape", model.shape, model.shape.size());
  CheckArray(path, "background", model.background, 3);
  CheckOptionalParts(path, model);
  // With a bust the mesh has more vertices than FLAME; only FLAME's have an offset.
  const size_t offsets = model.static_offset.size(), max = model.mesh.vertices.size();
  const bool shorter = model.bust && offsets < max && offsets % 3 == 0;
  if (offsets > 0) CheckArray(path, "static_offset", model.static_offset, shorter ? offsets : max);
}

std::string Shown(const std::string& name, const std::string& sha256) {
  return "'" + name + "' (sha256 " + (sha256.empty() ? "none" : sha256) + ")";
}

void CheckFlame(const std::string& where, const AvatarModel& model, const FlameModel& flame) {
  if (flame.sha256 != model.flame_sha256)
    throw Error(where,
                "flame",
                "the model is " + Shown(flame.name, flame.sha256) + ", the avatar was trained on " +
                    Shown(model.flame_name, model.flame_sha256));
}

namespace {

std::string TextOf(const FilmedFrom& filmed) {
  const auto degrees = [](float radians) { return radians * 57.29578f; };
  std::string text = Format("filmed from {:.0f} to {:.0f} degrees to its left, {:.0f} to {:.0f} up",
                            degrees(filmed.yaw[0]),
                            degrees(filmed.yaw[1]),
                            degrees(filmed.pitch[0]),
                            degrees(filmed.pitch[1]));
  if (filmed.guessed)
    text += Format("; {:.0f} % of its surface is in no frame, and guessed", 100 * *filmed.guessed);
  return text + "\n";
}

}  // namespace

std::string ToString(const BlendshapeFitFigures& fit, size_t scores) {
  return Format(
      "driven by {} blendshape scores, fitted to {} frames; held out: R2 {:.2f}, {:.2f} mm ({:.2f} "
      "mm without them)\n",
      scores,
      fit.frames,
      fit.r2,
      1e3 * fit.error,
      1e3 * fit.mean_face_error);
}

// FLAME's vertices and faces must come first; those of a bust may follow.
void CheckTopology(const std::string& where, const AvatarModel& model, const FlameModel& flame) {
  const auto check = [&](const char* what, bool of_avatar, bool of_model) {
    if (of_avatar != of_model)
      throw Error(where,
                  "flame",
                  std::string(of_avatar ? "the avatar, but not the model, has "
                                        : "the model, but not the avatar, has ") +
                      what + " added");
  };
  check("a mouth", model.has_mouth, flame.mouth.count() > flame.mouth.vhap_teeth);
  check("VHAP's teeth", model.has_vhap_teeth, flame.mouth.vhap_teeth > 0);
  check("eyelids", model.has_eyelids, flame.has_eyelids);
  const size_t vertices = model.mesh.vertices.size() / 3, faces = model.mesh.faces.size();
  const bool same_size = vertices == size_t(flame.vertex_count) && faces == flame.faces.size();
  const bool larger = vertices > size_t(flame.vertex_count) && faces > flame.faces.size();
  if (!(model.bust ? larger : same_size) ||
      !std::equal(flame.faces.begin(), flame.faces.end(), model.mesh.faces.begin()))
    throw Error(where,
                "flame",
                "'" + flame.name + "' has " + std::to_string(flame.vertex_count) +
                    " vertices and " + std::to_string(flame.faces.size()) +
                    " faces, the avatar's mesh has " + std::to_string(vertices) + " and " +
                    std::to_string(faces) + " or different face indices");
}

// Adds the canonical mesh as triangles, with a morph target per expression direction, or per one
// that has a name if some have, of a score of 1: at zero pose, and only there, FLAME's vertices are
// linear in the expression.
GlbMesh AddMesh(GlbDocument& document, const AvatarModel& model, const FlameModel* flame) {
  GlbPrimitive primitive;
  primitive.attributes["POSITION"] =
      AddValues<float>(document, model.mesh.vertices, 3, GlbUse::kPosition);
  std::vector<uint32_t> indices;
  for (const auto& face : model.mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
  primitive.indices = AddValues<uint32_t>(document, indices, 1, GlbUse::kIndices);
  GlbMesh mesh{"canonical mesh", {}, {}};
  const int expressions = flame && !model.canonical_frame ? flame->expression_count : 0;
  for (int e = 0; e < expressions; ++e) {
    const std::vector<std::string>& names = flame->expression_names;
    if (!names.empty() && names[size_t(e)].empty()) continue;
    const float score = names.empty() ? 1 : flame->expression_scores[size_t(e)];
    const size_t size = 3 * size_t(flame->vertex_count);
    std::vector<float> direction(model.mesh.vertices.size());  // a bust does not move
    for (size_t i = 0; i < size; ++i)
      direction[i] = score * flame->expression_directions[size_t(e) * size + i];
    primitive.targets.push_back(
        {{"POSITION", AddValues<float>(document, direction, 3, GlbUse::kPosition)}});
    mesh.extras["targetNames"].push_back(names.empty() ? "expression_" + std::to_string(e)
                                                       : names[size_t(e)]);
  }
  mesh.primitives.push_back(std::move(primitive));
  return mesh;
}

// Avatars trained on such a model before it was converted to metres are in its unit.
void CheckUnit(const AvatarModel& model, const FlameModel& flame) {
  if (flame.unit == 1 || model.size() == 0 || model.embedding.rigid) return;
  std::vector<float> scales;
  for (size_t i = 0; i < model.size(); ++i) {
    const float* s = model.gaussians.at(kScaleLog, i);
    scales.push_back(std::max({s[0], s[1], s[2]}));
  }
  const double ratio = std::exp(Median(scales)) / kFlameTemplateSize;
  if (ratio > 0.3 || ratio < 3e-4)
    throw Error("avatar",
                "unit",
                "its Gaussians are not of a size for a head in metres: it was trained on '" +
                    flame.name + "' when that was not converted to metres; train it again");
}

}  // namespace

Gaussians RestPose(const AvatarModel& model) {
  PosedGaussians posed;
  Bind(model, Surface(model.mesh), posed, CorrectionWeights(model.correction_map, {}));
  Gaussians rest = model.gaussians;
  if (!posed.color_dc.empty()) rest.values[kColorDc] = std::move(posed.color_dc);
  if (rest.corrections > 0) {
    rest.values[kOpacityLogit] = std::move(posed.opacity_logit);
    rest.corrections = 0;
    rest.values[kCorrection].clear();
  }
  rest.values[kPosition] = std::move(posed.position);
  rest.values[kRotation] = std::move(posed.rotation);
  rest.values[kScaleLog] = std::move(posed.scale_log);
  return rest;
}

void WriteAvatarGlb(const std::string& path,
                    const AvatarModel& model,
                    const FlameModel* flame,
                    const AvatarFileOptions& options) {
  CheckModel(path, model);
  if (flame) {
    CheckFlame(path, model, *flame);
    CheckTopology(path, model, *flame);
  }
  GlbDocument document;
  document.path = path;
  GlbPrimitive splats = AddSplats(document, RestPose(model), options.truncate_degree);
  // The mesh is in a second scene, because shown together it would hide the splats.
  const bool embed = options.embed_flame || (flame && flame->redistributable);
  const int mesh = embed ? 1 : -1;
  splats.extensions[kSplatExtension]["extensions"][kBindingExtension] =
      AddBinding(document, model, splats, mesh);
  document.meshes.push_back({"splats at rest", {std::move(splats)}, {}});
  document.scenes.push_back({"splats at rest", {0}});
  if (embed) {
    document.meshes.push_back(AddMesh(document, model, flame));
    document.scenes.push_back({"canonical mesh", {mesh}});
  }
  document.extensions_used = {kSplatExtension, kBindingExtension};
  WriteGlb(document);
}

AvatarModel ReadAvatarGlb(const std::string& path) {
  const GlbDocument document = ReadGlb(path, {kSplatExtension, kBindingExtension});
  const Json binding = FindBinding(FindSplats(document));
  if (binding.is_null())
    throw Error(path, kBindingExtension, "is missing: the file contains splats, but not an avatar");
  return ReadBinding(document, binding);
}

FlameModel LoadFlameOf(const AvatarModel& model,
                       const std::string& avatar_path,
                       const std::string& flame,
                       const std::string& option) {
  if (!flame.empty()) return FlameOf(model, LoadFlameModel(flame));
  if (model.flame_file.empty())
    throw Error(avatar_path,
                option,
                "is needed: the FLAME model " + Shown(model.flame_name, model.flame_sha256));
  FlameModel own = ParseFlameModel(avatar_path + "/flame.npz", model.flame_file);
  own.name = model.flame_name;
  return FlameOf(model, std::move(own));
}

void AttachMesh(AvatarModel& model, const FlameModel& flame, bool ignore_hash) {
  if (!ignore_hash) CheckFlame("avatar", model, flame);
  CheckUnit(model, flame);
  if (model.mesh.faces.empty()) {
    CanonicalMesh mesh = MakeCanonicalMesh(
        flame, model.shape, model.static_offset, model.bust, model.canonical_frame);
    for (int32_t triangle : model.embedding.triangle)
      if (size_t(triangle) >= mesh.faces.size())
        throw Error("avatar",
                    "flame",
                    "'" + flame.name + "' has " + std::to_string(mesh.faces.size()) +
                        " faces, the avatar uses face " + std::to_string(triangle));
    model.mesh = std::move(mesh);
  }
  CheckTopology("avatar", model, flame);
}

GlbSummary SummarizeGlb(const std::string& path) {
  const GlbDocument document = ReadGlb(path, {kSplatExtension, kBindingExtension});
  const GlbPrimitive& splats = FindSplats(document);
  GlbSummary summary;
  summary.extensions_used = document.extensions_used;
  const auto position = splats.attributes.find("POSITION");
  if (position == splats.attributes.end())
    throw Error(path, "POSITION", "is missing from the splats");
  summary.gaussians = ReadValues<float>(document, position->second, 3, "POSITION").size() / 3;
  while (summary.degree < kMaxSplatFileDegree &&
         splats.attributes.contains(SplatCoefficientName(CoefficientCount(summary.degree))))
    ++summary.degree;
  const Json binding = FindBinding(splats);
  if (!binding.is_null()) summary.avatar = SummarizeBinding(document, binding);
  return summary;
}

std::string ToString(const GlbSummary& summary) {
  std::string text = std::to_string(summary.gaussians) + " Gaussians, SH of degree " +
                     std::to_string(summary.degree) + " for every reader\n";
  if (summary.avatar) {
    const AvatarModel& a = summary.avatar->model;
    text += "avatar (binding version " + std::to_string(summary.avatar->version) +
            "): " + ToString(a.gaussians.basis) + " of degree " +
            std::to_string(a.gaussians.degree) + ", colours in the " + ToString(a.color_frame) +
            " frame\n";
    if (a.embedding.released)
      text += "follows the mesh by the rule of SplattingAvatar's released code\n";
    if (a.embedding.rigid) text += "follows the mesh by GaussianAvatars' rule\n";
    if (a.light) text += "lit by a light that stands still in the world\n";
    if (a.gaussians.corrections > 0)
      text += std::to_string(a.gaussians.corrections) +
              " corrections per Gaussian follow the expression\n";
    text += "FLAME model " + Shown(a.flame_name, a.flame_sha256) +
            (!a.flame_file.empty() ? Format(", in the file ({:.1f} MB; it may be passed on), ",
                                            double(a.flame_file.size()) / 1e6)
                                   : ", ") +
            std::to_string(a.shape.size()) + " shape coefficients, " +
            (a.static_offset.empty() ? "no" : "a") + " static offset" +
            (a.has_mouth ? ", teeth and a mouth added" : "") +
            (a.has_vhap_teeth ? ", VHAP's teeth added" : "") +
            (a.has_eyelids ? ", eyelids added\n" : "\n");
    text += "canonical mesh of " + std::to_string(summary.avatar->vertex_count) + " vertices and " +
            std::to_string(summary.avatar->face_count) + " faces" +
            (a.bust && a.bust->follow ? " with a bust that follows the head, "
             : a.bust                 ? " with a bust, "
                                      : ", ") +
            (a.mesh.faces.empty()
                 ? "not in the file: made from the FLAME model\n"
                 : Format("in the file with {} morph targets\n", summary.avatar->expression_count));
    if (a.filmed) text += TextOf(*a.filmed);
    if (a.blendshapes) text += ToString(a.blendshapes->fit, a.blendshapes->names.size());
  }
  text += "extensions:";
  for (const std::string& name : summary.extensions_used) text += " " + name;
  return text + "\n";
}

}  // namespace cosplat
