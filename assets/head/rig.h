// Joints, skinning weights and directions of the procedural head: HeadMesh -> FlameModel's arrays.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "assets/head/mesh.h"
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

// Appends shape and expression directions of the face's regions to `model`, which is of `mesh`.
void AddRegionalDirections(const HeadMesh& mesh, FlameModel& model);

// Where MediaPipe's face mesh has its points on this head.
LandmarkEmbedding FacePoints(const HeadMesh& mesh);

// Displacement of vertex v by the full expression (index into cosplat::Expression).
Vec ExpressionShift(const HeadMesh& mesh, int expression, int v);

// How rigidly a point of the head moves with an eye: 1 on lids and eyeball, 0 well away from them.
float NearEye(const Vec& p);

}  // namespace cosplat::procedural
