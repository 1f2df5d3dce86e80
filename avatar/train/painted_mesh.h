// What the training frames show of the mesh, with its hair: the colours of its vertices, guesses
// where no frame shows them, and how far the person reaches beyond it.
//
// Some training frames -> PaintedMesh -> ToVirtualView (virtual_views.h).
#pragma once

#include <array>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "avatar/surface/silhouette.h"
#include "avatar/train/head_regions.h"
#include "avatar/train/mesh_in_frame.h"
#include "avatar/train/wide_views.h"
#include "flame/model.h"
#include "splat/base/image.h"
#include "splat/math/vec.h"

namespace cosplat {

class PaintedMesh {
 public:
  // mesh: at rest. frames: those to learn from, at least one. scale: size of this head, 1 for the
  // template's.
  PaintedMesh(const FlameModel& flame,
              const CanonicalMesh& mesh,
              const std::vector<MeshInFrame>& frames,
              float scale);

  const Faces& faces() const { return faces_; }
  // Share of the surface without the bust that no frame shows.
  float GuessedShare() const { return guessed_share_; }
  float scale() const { return scale_; }
  // The frame with the mesh's vertices moved to where hair ends.
  MeshInFrame WithHair(const MeshInFrame& seen) const;

  // Of the point that a pixel shows, [0, 255].
  math::Vec3<float> ColorAt(const MeshPixel& at) const { return Mixed(colors_, at); }
  // The same as `seen` has it, as far as it shows that point. shown: of `seen`.
  math::Vec3<float> ColorIn(const MeshInFrame& seen,
                            const FrameOnMesh& shown,
                            const MeshPixel& at) const;
  // Whether it is of the mouth's inside, teeth or what is behind them; of the latter
  // (flame/mouth.h).
  bool IsInMouth(const MeshPixel& at) const {
    const size_t v = size_t(faces_[size_t(at.face)][0]);
    return mouth_begin_ <= v && v < mouth_end_;
  }
  bool IsBehindTeeth(const MeshPixel& at) const {
    return IsInMouth(at) && size_t(faces_[size_t(at.face)][0]) >= bowl_begin_;
  }
  // 1 where some frame's image has the point in it, falling to 0 beyond where all of them end.
  float InFrameAt(const MeshPixel& at) const { return Mixed(in_frame_, at); }
  // About the middle of the neck.
  BodyInFrame BodyIn(const MeshInFrame& seen) const;
  // [height, width] 255 outside of the drawn mesh, where the person may be nevertheless: within the
  // reach of the part of the head that is nearest. shown: what was drawn, with hair.
  Image8 BeyondMesh(const MeshInFrame& shown,
                    const std::vector<MeshPixel>& mesh,
                    const Camera& camera) const;

 private:
  template <class T>
  T Mixed(const std::vector<T>& of, const MeshPixel& at) const {
    const std::array<int32_t, 3>& f = faces_[size_t(at.face)];
    return of[size_t(f[0])] * at.u + of[size_t(f[1])] * at.v + of[size_t(f[2])] * (1 - at.u - at.v);
  }
  void LearnColors(const std::vector<MeshInFrame>& frames);
  // best: [V] the largest weight with which a frame shows the vertex.
  void GuessColors(const std::vector<float>& best);
  // What is behind the teeth: dark.
  void PaintMouth(const std::vector<float>& best);
  void MeasureGuesses(const std::vector<float>& best);
  void LearnReach(const std::vector<MeshInFrame>& frames);

  Faces faces_;
  size_t mouth_begin_, bowl_begin_, mouth_end_;  // vertices
  float scale_, guessed_share_ = 0;
  HeadRegions regions_;
  std::vector<float> hair_;                // [V] metres along the normal
  std::vector<math::Vec3<float>> colors_;  // [V]
  std::vector<float> in_frame_;            // [V]
  std::array<float, kHeadParts> reach_{};  // metres from the mesh with hair
};

}  // namespace cosplat
