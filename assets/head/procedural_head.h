// A head of our own with FLAME's make-up, generated without any file.
//
// MakeProceduralHead() -> FlameModel for tests and for the demonstration video
// (assets/head/video.h). The head is one component with two boundary loops (neck and throat;
// the lips, gums and teeth lie in front of the latter), the eyeballs are two closed ones.
// Axes, joints and array layouts are FLAME's; the coefficients' meaning is not: see Expression.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "assets/head/mesh.h"
#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

// Expression directions; a coefficient of 1 is the full expression, negative values are sensible
// only where said.
enum class Expression : int {
  kSmileLeft,
  kSmileRight,
  kFrown,  // corners of the mouth down
  kPucker,
  kFunnel,
  kLipsApart,
  kLipPress,
  kMouthShift,  // towards the subject's left; negative: right
  kBrowUp,      // negative: brows down
  kInnerBrowUp,
  kBrowKnit,
  kBlinkLeft,
  kBlinkRight,
  kSquint,
  kWideEyes,
  kCheekPuff,  // negative: hollow
  kSneer,
  kChinRaise,
  kCount
};
constexpr int kExpressionCount = int(Expression::kCount);

// The model and what texturing, animation and tests need beside it.
struct ProceduralHead {
  FlameModel model;
  procedural::HeadMesh mesh;             // rest positions are the model's template
  std::vector<float> ambient_occlusion;  // [V], share of the sky seen at rest
};

ProceduralHead MakeProceduralHeadParts();
FlameModel MakeProceduralHead();

// One frame as RGBA with straight alpha. `vertices` [V, 3] as FlamePoser gives them for `params`.
Image8 RenderProceduralHead(const ProceduralHead& head,
                            const std::vector<float>& vertices,
                            const FlameParams& params,
                            const Camera& camera);

}  // namespace cosplat
