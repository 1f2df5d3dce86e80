#include "assets/head/procedural_head.h"

#include "assets/head/raster.h"
#include "assets/head/rig.h"
#include "assets/head/shading.h"
#include "flame/math/rodrigues.h"

namespace cosplat {
namespace {

// The ears are not part of the solid from which occlusion is computed; they darken towards the
// concha.
float Occlusion(const procedural::Vec& p,
                const procedural::Vec& normal,
                const procedural::VertexLabel& label) {
  using procedural::Part;
  switch (label.part) {
    case Part::kSkin:
      return procedural::AmbientOcclusion(p, normal);
    case Part::kEar: {
      static constexpr float kByRing[] = {0.45f, 0.6f, 0.95f, 1, 0.95f, 0.75f, 0.85f, 0.5f, 0.3f};
      return kByRing[label.ear_ring];
    }
    default:
      return 1;  // shaded by their own rules
  }
}

ProceduralHead MakeHead(const procedural::NeckRig& neck) {
  ProceduralHead head;
  head.mesh = procedural::MakeHeadMesh();
  FlameModel& m = head.model;
  m.name = "procedural";
  m.redistributable = true;
  m.vertex_count = int(head.mesh.positions.size());
  m.shape_count = procedural::kShapeCount;
  m.expression_count = kExpressionCount;
  for (const auto& p : head.mesh.positions)
    m.template_vertices.insert(m.template_vertices.end(), {p.x, p.y, p.z});
  m.faces = head.mesh.faces;
  m.skinning_weights = procedural::SkinningWeights(head.mesh, neck);
  m.joint_regressor = procedural::JointRegressor(head.mesh, neck);
  m.shape_directions = procedural::ShapeDirections(head.mesh);
  m.expression_directions = procedural::ExpressionDirections(head.mesh);
  m.pose_directions = procedural::PoseDirections(head.mesh, m.skinning_weights);
  const auto normals = procedural::VertexNormals(head.mesh.positions, head.mesh.faces);
  for (size_t v = 0; v < normals.size(); ++v)
    head.ambient_occlusion.push_back(
        Occlusion(head.mesh.positions[v], normals[v], head.mesh.labels[v]));
  return head;
}

}  // namespace

ProceduralHead MakeProceduralHeadParts() { return MakeHead(procedural::kFilmedNeck); }

FlameModel MakeProceduralHead() { return MakeProceduralHeadParts().model; }

FlameModel MakeHeadForPeople() { return MakeHeadForPeopleParts().model; }

ProceduralHead MakeHeadForPeopleParts() {
  ProceduralHead head = MakeHead(procedural::kNeckOfPeople);
  procedural::OpenMouth(head);
  head.model.landmarks = procedural::FacePoints(head.mesh);
  procedural::ShiftToMeanOfPeople(head.mesh, head.model);
  procedural::SetArkitExpressions(head.mesh, head.model);
  procedural::AddRegionalDirections(head.mesh, head.model);
  head.model.has_eyelids = true;
  return head;
}

Image8 RenderProceduralHead(const ProceduralHead& head,
                            const std::vector<float>& vertices,
                            const FlameParams& params,
                            const Camera& camera) {
  procedural::ShadedPose pose;
  for (size_t i = 0; i < vertices.size(); i += 3)
    pose.vertices.push_back(math::ToVec3(&vertices[i]));
  pose.posed_from_rest = flame_math::Rodrigues(math::ToVec3(params.pose[0])) *
                         flame_math::Rodrigues(math::ToVec3(params.pose[1]));
  const bool lids_last = head.model.has_eyelids;
  auto coefficient = [&](Expression e, int from_end) {
    const size_t at = size_t(lids_last ? head.model.expression_count - from_end : int(e));
    return at < params.expression.size() ? params.expression[at] : 0.0f;
  };
  pose.blink_left = coefficient(Expression::kBlinkLeft, 2);
  pose.blink_right = coefficient(Expression::kBlinkRight, 1);
  const procedural::HeadShader shader(head, pose, math::ToVec3(camera.Center()));
  return procedural::Rasterize(vertices, head.model.faces, camera, shader);
}

}  // namespace cosplat
