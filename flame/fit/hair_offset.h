// How far hair stands out from FLAME's head, which has none. Private to flame/fit/.
//
// Frames and their mattes -> FitHairOffset -> the head's static offset. Without it, what hair shows
// moves otherwise than the skull that stands for it, by centimetres of depth.
#pragma once

#include <vector>

#include "flame/fit/frame_field.h"
#include "flame/model.h"

namespace cosplat::internal {

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
