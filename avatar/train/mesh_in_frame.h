// The posed mesh in a training frame: what the frame shows of which of its points.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "avatar/surface/silhouette.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/math/vec.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

using Faces = std::vector<std::array<int32_t, 3>>;

struct MeshInFrame {
  const TrainFrame* frame = nullptr;  // with alpha
  std::vector<float> vertices;        // [V, 3] metres, in the camera's world

  math::Vec3<float> Vertex(size_t v) const { return math::ToVec3(&vertices[3 * v]); }
  // The share of the person in a pixel, [0, 255].
  uint8_t Alpha(size_t pixel) const { return frame->target.data[4 * pixel + 3]; }
};

// [V] of unit length, or zero.
std::vector<math::Vec3<float>> NormalsOf(const std::vector<float>& vertices, const Faces& faces);

// Whether a point is in the image, with neighbours on all sides; and its pixel then.
bool IsIn(const Camera& camera, const ImagePoint& at);
size_t PixelOf(const Camera& camera, const ImagePoint& at);

// The cosine at which a surface faces the camera.
float Facing(const Camera& camera, const math::Vec3<float>& point, const math::Vec3<float>& normal);

// Of a colour's [0, 255].
inline uint8_t ToByte(float value) { return uint8_t(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

// A frame's colours, to be looked up by points of the mesh.
class FrameOnMesh {
 public:
  // scale: size of this head, 1 for the template's. Keeps a reference to the frame.
  FrameOnMesh(const MeshInFrame& seen, const Faces& faces, float scale);

  struct Sample {
    math::Vec3<float> color{0, 0, 0};  // [0, 255]
    // How well the frame shows the point: from 0 (hidden, seen from behind, outside of the image or
    // of the person) to 1.
    float weight = 0;
  };
  Sample At(const math::Vec3<float>& point, const math::Vec3<float>& normal) const;

 private:
  const TrainFrame& frame_;
  float hidden_;  // metres
  std::vector<MeshPixel> mesh_;
  Image from_person_;  // px, negative inside
};

}  // namespace cosplat
