// Joints, skinning weights and directions of the procedural head: HeadMesh -> FlameModel's arrays.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "assets/head/mesh.h"
#include "assets/head/procedural_head.h"
#include "flame/model.h"

namespace cosplat::procedural {

// Root, neck, jaw, left eye, right eye at rest.
std::array<Vec, kFlameJoints> JointPositions();

// [V, 5], rows sum to 1.
std::vector<float> SkinningWeights(const HeadMesh& mesh);

// [5, V], rows sum to 1: regresses JointPositions() at rest and follows the vertices around each
// joint.
std::vector<float> JointRegressor(const HeadMesh& mesh);

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
