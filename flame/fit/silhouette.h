// The mesh's outline in a frame, drawn to the rim of the frame's matte. Private to flame/fit/.
//
// What landmarks do not measure: ears, skull, neck and the width of the head. The points are those
// where the surface turns away from the camera, found anew for each fit (iterated closest points;
// Besl and McKay 1992), and the nearest rim is looked up as a distance (Fitzgibbon 2003).
#pragma once

#include <memory>

#include "flame/fit/field_cost.h"

namespace cosplat::internal {

// A point on an edge of the mesh.
struct OutlinePoint {
  std::array<int32_t, 2> vertices;
  double toward_second;     // 0 to 1: where between them
  double distance;          // px, outside the matte's rim; negative inside
  double pixels_per_metre;  // at its depth
  bool more_in_matte;  // the matte may have more than the mesh: hair, or beyond the mesh's border
};

class Silhouette {
 public:
  Silhouette(const FlameModel& model, int shape_count, int expression_count);

  // Where the surface turns away from the camera with nothing of the mesh behind, and the mesh's
  // border; thinned out to be even. Empty if a point is not in front of the camera.
  std::vector<OutlinePoint> Outline(const double* shape,
                                    double log_focal,
                                    const double* frame,
                                    const FrameField& rim,
                                    const FrameView& view) const;

  // The outline should lie on the rim where it is near it, and must not be outside where the matte
  // has more. Null if there is no such point. Keeps references to rim and view.
  std::unique_ptr<FieldCost> Cost(const double* shape,
                                  double log_focal,
                                  const double* frame,
                                  const FrameField& rim,
                                  const FrameView& view) const;

  // Per vertex: whether it is above the eyes, where hair may stand out from the head.
  const std::vector<bool>& may_have_hair() const { return may_have_hair_; }

 private:
  struct Edge {
    std::array<int32_t, 2> vertices;
    bool border;  // of one triangle only
  };
  struct Posed;
  Posed PosedIn(const double* shape,
                double log_focal,
                const double* frame,
                const FrameView& view) const;

  const FlameModel& model_;
  const int shape_count_, expression_count_;
  std::vector<std::array<int32_t, 3>> faces_;
  std::vector<Edge> edges_;
  std::vector<bool> may_have_hair_;
  std::vector<int32_t> place_;  // of each vertex among the points of surface_, or -1
  const PointsOnFlame surface_;
};

// How far hair stands out from FLAME's head, which has none: without it, what hair shows moves
// otherwise than the skull that stands for it, by centimetres of depth.
//
// A smooth offset along the normals of the vertices above the eyes and behind them, such that the
// mesh's outline meets the rims of the mattes in the frames `picked`. shape, frames: numbers of
// PointsOnFlame. views, fields: per frame (ReadFields); frames without a rim do not count. Returns
// [V, 3] metres, or nothing if no rim shows hair.
std::vector<float> FitHairOffset(const FlameModel& model,
                                 const std::vector<double>& shape,
                                 double log_focal,
                                 const std::vector<std::vector<double>>& frames,
                                 const std::vector<size_t>& picked,
                                 const std::vector<std::optional<FrameView>>& views,
                                 const std::vector<FrameFields>& fields);

}  // namespace cosplat::internal
