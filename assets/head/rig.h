// Joints, skinning weights and directions of the procedural head: HeadMesh -> FlameModel's arrays.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "assets/head/mesh.h"
#include "assets/head/procedural_head.h"
#include "flame/model.h"

namespace cosplat::procedural {

// About what the head turns on its neck, and which part of the skin turns with it: none below
// `from` and all above `to`, heights that fall by `slope` towards the front. Metres.
struct NeckRig {
  Vec joint;
  float from, to, slope;
};
// The filmed head turns about the foot of its neck.
inline constexpr NeckRig kFilmedNeck{{0, -0.092f, -0.050f}, -0.150f, -0.078f, 0.25f};
// People turn theirs between the ears, on the atlas, as FLAME's does. What a collar covers stays at
// rest: skin that moved there would hold the head back, since images show that it does not, and the
// track would tilt too little (docs/tried.md).
inline constexpr NeckRig kNeckOfPeople{{0, -0.009f, -0.054f}, -0.120f, -0.045f, 0.375f};

// Root, neck, jaw, left eye, right eye at rest.
std::array<Vec, kFlameJoints> JointPositions(const NeckRig& neck);

// [V, 5], rows sum to 1.
std::vector<float> SkinningWeights(const HeadMesh& mesh, const NeckRig& neck);

// [5, V], rows sum to 1: regresses JointPositions() at rest and follows the vertices around each
// joint.
std::vector<float> JointRegressor(const HeadMesh& mesh, const NeckRig& neck);

// [count, V, 3]
constexpr int kShapeCount = 12;
std::vector<float> ShapeDirections(const HeadMesh& mesh);
std::vector<float> ExpressionDirections(const HeadMesh& mesh);
std::vector<float> PoseDirections(const HeadMesh& mesh, const std::vector<float>& weights);

// A field of displacements at p, but lids and eyeball move rigidly together, so that they continue
// to fit each other.
Vec RigidAtEyes(const std::function<Vec(const Vec&)>& field, const Vec& p, Part part);

// Takes teeth, gums and throat out of the mesh and the model.
void OpenMouth(ProceduralHead& head);

// Moves the template of `model`, which is of `mesh`, to the mean of people's faces.
void ShiftToMeanOfPeople(const HeadMesh& mesh, FlameModel& model);

// ARKit's blendshapes in place of the expression directions that `model` has, which is of `mesh`;
// the lids' are the last two.
void SetArkitExpressions(const HeadMesh& mesh, FlameModel& model);

// Appends shape directions of the face's regions, and inserts expression directions before the
// named ones.
void AddRegionalDirections(const HeadMesh& mesh, FlameModel& model);

// Where MediaPipe's face mesh has its points on this head.
LandmarkEmbedding FacePoints(const HeadMesh& mesh);

// Displacement of vertex v by the full expression (index into cosplat::Expression).
Vec ExpressionShift(const HeadMesh& mesh, int expression, int v);

// Displacement of vertex v by lids that turn by so many degrees upwards.
Vec LidShift(const HeadMesh& mesh, int v, bool left, float upper, float lower);

// How rigidly a point of the head moves with an eye: 1 on lids and eyeball, 0 well away from them.
float NearEye(const Vec& p);

}  // namespace cosplat::procedural
