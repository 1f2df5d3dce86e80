// Teeth and the inside of the mouth, which FLAME's mesh does not have: behind its lips is a hole.
//
// LoadFlameModel -> WithMouth -> FlamePoser and the avatar's mesh, which need not know of it: the
// new vertices are vertices of a model like FLAME. Everything is derived from the rim of the hole,
// so that nothing of FLAME's data, nor of anybody's teeth, is part of this program.
#pragma once

#include <vector>

#include "flame/model.h"

namespace cosplat {

// Number of the geometry below, kept in avatar files: a change of it makes them unplayable.
constexpr int kMouthGeometry = 1;

// `model` with vertices and faces added after its own, as components of their own: the upper teeth,
// which move with the head, the lower teeth, which move with the jaw, and behind them a bowl that
// moves with the rim of the hole. The number of coefficients and the joints are unchanged; teeth
// follow the subject's shape, not the expression. Returned unchanged if the mesh has no such hole
// (a boundary loop above the neck's whose lower part moves with the jaw, and which is no deeper
// behind the face than it is wide) or has an added mouth already.
FlameModel WithMouth(FlameModel model);

// A track's static offset for the vertices of `model`. An added mouth gets none, except that its
// teeth move by the mean of those that VHAP's track has for its own 120 vertices of teeth, if it
// has them; without a mouth, these are dropped. An offset of another size is returned unchanged.
std::vector<float> StaticOffsetFor(const FlameModel& model, std::vector<float> offset);

}  // namespace cosplat
