// A synthetic head with FLAME's structure, generated without any data file.
//
// MakeProceduralHead() -> FlameModel for tests and for the demonstration video
// (assets/head/video.h). The head is one component with two boundary loops (neck and throat; lips,
// gums and teeth lie in front of the throat), the eyeballs are two closed components. Axes, joints
// and array layouts are FLAME's; the meaning of the coefficients is not, see Expression.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "assets/head/mesh.h"
#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

// Expression directions. A coefficient of 1 is the full expression; negative values are meaningful
// only where stated.
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

// The model and the data that texturing, animation and tests need in addition.
struct ProceduralHead {
  FlameModel model;
  procedural::HeadMesh mesh;             // rest positions are the model's template
  std::vector<float> ambient_occlusion;  // [V], visible share of the sky at rest
};

ProceduralHead MakeProceduralHeadParts();
FlameModel MakeProceduralHead();
// The same head to be fitted to people: with their mean face in place of its own (`mesh` stays at
// rest as sculpted, which paint and shading go by) and a hole behind the lips; its expressions are
// 45 directions of the face's regions and 44 of ARKit's blendshapes by name; 85 directions of
// regions follow its shapes; and it has landmarks.
ProceduralHead MakeHeadForPeopleParts();
FlameModel MakeHeadForPeople();

// Renders one frame as RGBA with straight alpha. `vertices`: [V, 3] from FlamePoser for `params`.
Image8 RenderProceduralHead(const ProceduralHead& head,
                            const std::vector<float>& vertices,
                            const FlameParams& params,
                            const Camera& camera);

}  // namespace cosplat
