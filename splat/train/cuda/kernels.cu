#include "splat/device/cuda/kernels.cuh"
#include "splat/device/gather.h"
#include "splat/train/cuda/kernels.h"
#include "splat/train/density/kernels/control.h"
#include "splat/train/density/kernels/smoothing.h"
#include "splat/train/loss/kernels/crop.h"
#include "splat/train/loss/kernels/photograph.h"
#include "splat/train/optimize/kernels/adam.h"
#include "splat/train/prune/kernels/prune_mask.h"
#include "splat/train/ranks/kernels/shards.h"
#include "splat/train/state/kernels/statistics.h"
#include "splat/train/step/kernels/step.h"
#include "splat/train/subject/kernels/add_offsets.h"

namespace cosplat::cuda {

namespace {

struct UpdateOne {
  UpdateNumbers all;
  __device__ void operator()(size_t i) const {
#pragma unroll
    for (int a = 0; a < kAttributeCount; ++a)
      if (i < all.attributes[a].numbers) Update(all.attributes[a], i);
  }
  __device__ void Update(const AdamArray& a, size_t i) const {
    const uint32_t late = all.behind[i / a.width / kGaussianGroup];
    if (late == kNotNow) return;
    const math::AdamStep step{a.beta1, a.beta2, a.step_size, a.scaled_eps};
    const float scale = a.rate_scale ? a.rate_scale[i] : 1.0f;
    float value = a.value[i], m = a.m[i], v = a.v[i];
    if (late > 0) math::AdamCatchUp(step, math::AdamTailOf(step, int(late)), value, m, v, scale);
    if (a.gradient) {
      const bool usable = math::IsUsableGradient(a.gradient[i]);
      if (!usable) atomicAdd(all.ignored, 1u);
      math::AdamUpdate(step, usable ? a.gradient[i] : 0.0f, value, m, v, scale);
    }
    a.value[i] = value;
    a.m[i] = m;
    a.v[i] = v;
  }
};

template <class Kernel>
struct PartOfGroup {
  Kernel kernel;
  __device__ void operator()(size_t i) const {
    kernel.template Part<kGroupParts>(i / kGroupParts, i % kGroupParts);
  }
};

// Registers kernels that process groups.
template <class... Kernels>
void ProvideGroups() {
  ((KernelLaunch<Kernels>::function =
        [](size_t n, Stream& stream, const Kernels& kernel) {
          ForEachThread(n * kGroupParts, stream, PartOfGroup<Kernels>{kernel});
        }),
   ...);
}

}  // namespace

void ProvideTrainKernels() {
  KernelLaunch<UpdateNumbers>::function = [](size_t n, Stream& stream, const UpdateNumbers& all) {
    ForEachThread(n, stream, UpdateOne{all});
  };
  Provide<FindBehind>();
  Provide<AccumulateStep, AddContributions, Weaken, ColorCurvatureBackward>();
  Provide<SumBlocks<NeedleLengths>,
          SumBlocks<View<const NeedleSum>>,
          AddUpNeedles,
          NeedlesBackward>();
  Provide<SumBlocks<ShownMasks>, SumBlocks<View<const double>>, AddUpShown>();
  Provide<FindKinds,
          StrengthKey,
          LetStay,
          ShareOpacity,
          FlagKinds,
          PlaceSources,
          DrawChild,
          CutChild>();
  Provide<MarkUnwanted, FlagKept, PlaceKept, LowerTo, AddOffsets, FillNumbers>();
  Provide<FindBoxes, JoinBoxes, LowKeys, HighKeys>();
  Provide<GatherRow<float>, GatherRow<uint8_t>, GatherRow<int32_t>>();
  Provide<CopyCrop, AddCrop>();
  Provide<FindDrawn, MarkSeen, ScatterRow, SpoilBroken>();
  ProvideGroups<CopyGroup, AddGroup, ZeroUnseenGroup>();
  Provide<FindSmoothing>();
  Provide<PhotographForward, PhotographBackward, AddUpExposure, StepExposure, CenterExposures>();
  Provide<SumBlocks<View<const ExposureSum>>>();
  Provide<HideMasked, DimMasked, LearnMask>();
}

}  // namespace cosplat::cuda
