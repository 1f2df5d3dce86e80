#include "avatar/model/place_bust.h"
#include "avatar/surface/cuda/kernels.h"
#include "avatar/surface/kernels/bust.h"
#include "avatar/surface/kernels/embed.h"
#include "avatar/surface/kernels/holes.h"
#include "avatar/surface/kernels/light.h"
#include "avatar/surface/kernels/place.h"
#include "avatar/surface/kernels/surface.h"
#include "avatar/surface/kernels/walk.h"
#include "flame/kernels/pose.h"
#include "splat/device/cuda/kernels.cuh"
#include "splat/device/gather.h"

namespace cosplat::cuda {

void ProvideAvatarKernels() {
  Provide<flame_math::BlendShapesKernel<float>, flame_math::SkinKernel<float>>();
  ProvideRows<PoseFacesKernel,
              PoseVerticesKernel,
              VerticesVjpKernel,
              FacesVjpKernel,
              EmbedKernel,
              EmbedVjpKernel,
              RigidEmbedKernel>();
  Provide<math::PutPositionsKernel, math::SumCornersKernel, math::SumAtVertexKernel>();
  Provide<FaceKeys, FindBegin>();
  Provide<WalkOne, ListTouching, CountOnFace, TakeEach, SettleWalk, ForgetMoment>();
  Provide<MoveEach, PlaceEach, RateEach, ScaleEach>();
  Provide<PlaceBust, SumBust, AdvanceBust>();
  Provide<SumLight, SumBlocks<View<const LightSum>>, AddUpLight, AdvanceLight>();
  Provide<FindLast, ThinOut, FindHoles, SpareOne>();
  Provide<GatherRow<std::array<float, 2>>>();
}

}  // namespace cosplat::cuda
