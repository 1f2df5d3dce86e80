#include "assets/head/raster.h"
#include "assets/head/shading.h"
#include "assets/head/video.h"
#include "flame/math/rodrigues.h"

namespace cosplat {

Image8 RenderProceduralHead(const ProceduralHead& head,
                            const std::vector<float>& vertices,
                            const FlameParams& params,
                            const Camera& camera) {
  procedural::ShadedPose pose;
  for (size_t i = 0; i < vertices.size(); i += 3)
    pose.vertices.push_back({vertices[i], vertices[i + 1], vertices[i + 2]});
  pose.posed_from_rest = flame_math::Times(flame_math::Rodrigues(params.pose[0]),
                                           flame_math::Rodrigues(params.pose[1]));
  auto coefficient = [&](Expression e) {
    return size_t(e) < params.expression.size() ? params.expression[size_t(e)] : 0.0f;
  };
  pose.blink_left = coefficient(Expression::kBlinkLeft);
  pose.blink_right = coefficient(Expression::kBlinkRight);
  const auto eye = camera.Center();
  const procedural::HeadShader shader(head, pose, {eye[0], eye[1], eye[2]});
  return procedural::Rasterize(vertices, head.model.faces, camera, shader);
}

}  // namespace cosplat
