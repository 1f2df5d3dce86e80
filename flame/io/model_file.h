// FLAME model files: FLAME's own .pkl, and .npz with the same arrays.
//
//   v_template [V, 3], f or faces [F, 3], shapedirs* [V, 3, S + E] (shape first), posedirs*
//   [V, 3, 36], J_regressor [5, V] (dense or scipy csc), weights [V, 5], kintree_table [2, 5] or
//   parents [5]; optional numbers n_shape, n_expr, redistributable.
//
// A template of 426 or 43 units, or of 0.0004, is one in millimetres, centimetres or kilometres
// (kFlameTemplateSize, within a factor of 3) and is converted to metres; other sizes are left.
//
// Without n_shape and n_expr, the first 300 directions are shape, as in FLAME's own files, and the
// rest expression. Trailing all-zero directions of either group are dropped: they have no effect
// and make up most of a reduced model.
#pragma once

#include <string>

#include "flame/model.h"

namespace cosplat {

// The path's extension selects the format. The returned model is valid (Validate); its sha256 is
// that of the file. redistributable is false unless the .npz says otherwise: no FLAME file is
// assumed to be free. Throws Error naming file, array and shape or value.
FlameModel LoadFlameModel(const std::string& path);

// Writes an .npz that LoadFlameModel reads back unchanged (except for name and sha256).
void WriteFlameModelNpz(const std::string& path, const FlameModel& model);

}  // namespace cosplat
