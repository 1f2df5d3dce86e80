#include <algorithm>
#include <cmath>

#include "avatar/io/binding_extension.h"
#include "avatar/math/correct.h"
#include "flame/eyelids.h"
#include "flame/mouth.h"
#include "flame/vhap_teeth.h"
#include "splat/io/splat_primitive.h"

namespace cosplat {
namespace {

// The numbers of a basis are steps of 16 bits; below the minimum they change nothing visible.
constexpr float kMaxSteps = 32767;
constexpr float kMinCorrection = 1e-9f;

int AddArray(GlbDocument& document, View<const float> values, int width) {
  return AddValues(document, values, width, GlbUse::kData);
}

int AddTriangles(GlbDocument& document, const AvatarModel& model) {
  const std::vector<uint32_t> indices(model.embedding.triangle.begin(),
                                      model.embedding.triangle.end());
  return AddValues<uint32_t>(document, indices, 1, GlbUse::kData);
}

int AddBarycentric(GlbDocument& document, const AvatarModel& model) {
  std::vector<float> flat;
  flat.reserve(2 * model.size());
  for (const auto& [u, v] : model.embedding.barycentric) flat.insert(flat.end(), {u, v});
  return AddArray(document, flat, 2);
}

// Adds coefficient k >= 1 of every Gaussian; glTF has no accessor wide enough for all coefficients.
int AddCoefficient(GlbDocument& document, const AvatarModel& model, int k) {
  std::vector<float> values(3 * model.size());
  for (size_t i = 0; i < model.size(); ++i)
    std::copy_n(model.gaussians.at(kColorRest, i) + 3 * (k - 1), 3, &values[3 * i]);
  return AddArray(document, values, 3);
}

Json AddColor(GlbDocument& document, const AvatarModel& model, const GlbPrimitive& splats) {
  Json accessors = Json::array();
  for (int k = 1; k < CoefficientCount(model.gaussians.degree); ++k) {
    const auto standard = splats.attributes.find(SplatCoefficientName(k));
    const bool same = model.gaussians.basis == Basis::kSh && standard != splats.attributes.end();
    accessors.push_back(same ? standard->second : AddCoefficient(document, model, k));
  }
  return accessors;
}

// As doubles, whose text round-trips to the same float.
Json Numbers(View<const float> values) {
  Json numbers = Json::array();
  for (float value : values) numbers.push_back(double(value));
  return numbers;
}

// Replaces invalid UTF-8: a file name may contain any bytes, JSON may not.
std::string Utf8(const std::string& text) {
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
}

// Adds the fields that version 1 lacks. Readers of version 1 would render such an avatar wrongly.
void AddVersion2(const AvatarModel& model, Json& binding) {
  if (model.embedding.released)
    binding["rule"] = {{"name", kReleasedRule}, {"unit", double(model.embedding.released->unit)}};
  if (model.embedding.rigid) binding["rule"] = {{"name", kRigidRule}};
  if (model.canonical_frame) {
    const FlameParams& frame = *model.canonical_frame;
    // tinygltf writes an empty array as null; missing coefficients are zero.
    const std::vector<float> none{0.0f};
    Json pose = Json::array();
    for (const auto& joint : frame.pose) pose.push_back(Numbers(joint));
    binding["canonicalFrame"] = {
        {"expression", Numbers(frame.expression.empty() ? none : frame.expression)},
        {"pose", pose},
        {"translation", Numbers(frame.translation)}};
  }
}

// The bases as multiples of a step for each of a basis's 14 numbers: half the bytes of floats.
// Steps are powers of two, so that an avatar that is read and written again stays the same.
Json CorrectionsOf(GlbDocument& document, const AvatarModel& model) {
  const CorrectionMap& map = model.correction_map;
  const Buffer<float>& bases = model.gaussians.values[kCorrection];
  std::array<float, math::kCorrectionWidth> step{};
  for (size_t i = 0; i < bases.size(); ++i)
    step[i % step.size()] = std::max(step[i % step.size()], std::abs(bases[i]));
  for (float& s : step)
    s = std::exp2(std::ceil(std::log2(std::max(s, kMinCorrection) / kMaxSteps)));
  std::vector<int16_t> steps(bases.size());
  for (size_t i = 0; i < bases.size(); ++i)
    steps[i] = int16_t(std::lround(bases[i] / step[i % step.size()]));
  return {{"count", model.gaussians.corrections},
          {"mean", Numbers(map.mean)},
          {"matrix", Numbers(map.matrix)},
          {"least", Numbers(map.min)},
          {"most", Numbers(map.max)},
          {"step", Numbers(step)},
          {"bases", AddValues<int16_t>(document, steps, 1, GlbUse::kData)}};
}

// Adds the fields that version 2 lacks.
void AddVersion3(const AvatarModel& model, Json& binding) {
  if (model.bust && model.bust->follow) {
    const BustFollow& follow = *model.bust->follow;
    binding["bust"]["follow"] = {{"headMean", Numbers(follow.head_mean)},
                                 {"matrix", Numbers(follow.matrix)},
                                 {"mean", Numbers(follow.mean)},
                                 {"least", Numbers(follow.min)},
                                 {"most", Numbers(follow.max)}};
  }
}

// Readers that do not know the field play the avatar as well, so that it needs no newer version.
Json BlendshapesOf(GlbDocument& document, const BlendshapeMap& map) {
  const BlendshapeFitFigures& fit = map.fit;
  return {{"names", map.names},
          {"least", Numbers(map.min)},
          {"most", Numbers(map.max)},
          {"offset", Numbers(map.offset)},
          {"matrix", AddArray(document, map.matrix, 1)},
          {"fit",
           {{"frames", fit.frames},
            {"r2", double(fit.r2)},
            {"error", double(fit.error)},
            {"meanFaceError", double(fit.mean_face_error)}}}};
}

int VersionOf(const AvatarModel& model) {
  if (model.light || model.gaussians.corrections > 0) return 4;
  if ((model.bust && model.bust->follow) || model.has_mouth || model.has_vhap_teeth ||
      model.has_eyelids)
    return 3;
  const Embedding& embedding = model.embedding;
  return embedding.released || embedding.rigid || model.canonical_frame ? 2 : 1;
}

}  // namespace

std::string ToString(ColorFrame frame) {
  return frame == ColorFrame::kSurface ? "surface" : "world";
}

Json AddBinding(GlbDocument& document,
                const AvatarModel& model,
                const GlbPrimitive& splats,
                int mesh) {
  const auto& values = model.gaussians.values;
  Json binding;
  binding["version"] = VersionOf(model);
  AddVersion2(model, binding);
  binding["degree"] = model.gaussians.degree;
  binding["basis"] = ToString(model.gaussians.basis);
  binding["colorFrame"] = ToString(model.color_frame);
  binding["triangle"] = AddTriangles(document, model);
  binding["barycentric"] = AddBarycentric(document, model);
  binding["offset"] = AddArray(document, values[kPosition], 3);
  binding["rotation"] = AddArray(document, values[kRotation], 4);
  binding["scaleLog"] = AddArray(document, values[kScaleLog], 3);
  binding["opacityLogit"] = AddArray(document, values[kOpacityLogit], 1);
  // At rest the colours are corrected and lit.
  binding["colorDc"] = model.gaussians.corrections > 0 || model.light
                           ? AddArray(document, values[kColorDc], 3)
                           : splats.attributes.at(SplatCoefficientName(0));
  if (model.gaussians.degree > 0) binding["colorRest"] = AddColor(document, model, splats);
  binding["flame"] = {{"name", Utf8(model.flame_name)}, {"sha256", model.flame_sha256}};
  if (!model.flame_file.empty())
    binding["flame"]["file"] = AddValues<char>(document, model.flame_file, 1, GlbUse::kData);
  if (model.has_mouth) binding["flame"]["mouth"] = kMouthGeometry;
  if (model.has_vhap_teeth) binding["flame"]["mouth"] = kVhapTeethGeometry;
  if (model.has_eyelids) binding["flame"]["eyelids"] = kEyelidGeometry;
  if (!model.shape.empty()) binding["shape"] = AddArray(document, model.shape, 1);
  if (!model.static_offset.empty())
    binding["staticOffset"] = AddArray(document, model.static_offset, 3);
  binding["background"] = Numbers(model.background);
  if (model.bust)
    binding["bust"] = {{"rotation", Numbers(model.bust->rotation)},
                       {"translation", Numbers(model.bust->translation)}};
  AddVersion3(model, binding);
  if (model.gaussians.corrections > 0) binding["corrections"] = CorrectionsOf(document, model);
  if (model.light) binding["light"] = Numbers(*model.light);
  if (model.trained_range)
    binding["trainedRange"] = {{"expressionLeast", Numbers(model.trained_range->expression_least)},
                               {"expressionMost", Numbers(model.trained_range->expression_most)},
                               {"angle", Numbers(model.trained_range->angle)}};
  if (const auto& filmed = model.filmed) {
    binding["filmed"] = {{"yaw", Numbers(filmed->yaw)}, {"pitch", Numbers(filmed->pitch)}};
    if (filmed->guessed) binding["filmed"]["guessed"] = *filmed->guessed;
  }
  if (model.blendshapes) binding["blendshapes"] = BlendshapesOf(document, *model.blendshapes);
  binding["canonicalMesh"] = {{"vertexCount", model.mesh.vertices.size() / 3},
                              {"faceCount", model.mesh.faces.size()}};
  if (mesh >= 0) binding["canonicalMesh"]["mesh"] = mesh;
  return binding;
}

}  // namespace cosplat
