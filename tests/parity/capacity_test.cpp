// Lists with capacity for another number of instances than there are:
// splat/render/cuda/tile_lists.h.
#include <gtest/gtest.h>

#include "splat/gaussians.h"
#include "splat/render/cuda/rasterizer.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/parity_case.h"

namespace cosplat {
namespace {

using cuda::SumOrder;

class Capacity : public test::DeviceTest {};

struct Drawn {
  std::vector<float> color, d_position;
  size_t instances = 0, capacity = 0;
  bool exceeded = false;
};

// There and back. expected: null where the host waits.
Drawn Draw(const test::ParityCase& c, SumOrder order, const size_t* expected) {
  cuda::CudaRasterizer rasterizer(order);
  Stream& stream = rasterizer.stream();
  Gaussians gaussians, gradients;
  cuda::CudaTape tape(true, order);
  RenderedImage image;
  Buffer<float> d_color, screen;
  Buffer<uint32_t> exceeded;
  gaussians.Upload(c.gaussians, stream);
  gradients.RefillLike(gaussians, stream);
  exceeded.Refill(1, stream);
  exceeded.FillWithZeros(stream);
  if (expected) tape.lists.Expect(*expected, exceeded.data());
  rasterizer.Forward(ViewOf(gaussians), gaussians.basis, c.camera, c.settings, image, tape);
  const std::vector<float> ones(image.color.size(), 1.0f);
  d_color.Upload(ones.data(), ones.size(), stream);
  rasterizer.Backward(
      ViewOf(gaussians), image, d_color, tape, GradientViewOf(gradients, screen, stream));
  Drawn drawn;
  drawn.color.resize(image.color.size());
  drawn.d_position.resize(3 * gaussians.size());
  image.color.Download(drawn.color.data(), stream);
  gradients.values[kPosition].Download(drawn.d_position.data(), stream);
  Readback<InstanceCounts> counts(stream);
  Readback<uint32_t> flag(stream);
  drawn.instances = counts.Get(tape.counts(), stream).instances;
  drawn.exceeded = flag.Get(exceeded.data(), stream) != 0;
  drawn.capacity = tape.capacity();
  return drawn;
}

class CapacityOf : public Capacity, public testing::WithParamInterface<SumOrder> {};
INSTANTIATE_TEST_SUITE_P(Order,
                         CapacityOf,
                         testing::Values(SumOrder::kAny, SumOrder::kFixed),
                         [](const auto& order) {
                           return order.param == SumOrder::kAny ? "Any" : "Fixed";
                         });

TEST_P(CapacityOf, MoreThanIsNeededChangesNothing) {
  const test::ParityCase c = test::RandomCase("capacity", 200, 40, 24, Basis::kDcsh, 1);
  const Drawn waited = Draw(c, GetParam(), nullptr);
  EXPECT_EQ(waited.capacity, waited.instances);
  for (const size_t capacity : {waited.instances, 2 * waited.instances + 5}) {
    const Drawn drawn = Draw(c, GetParam(), &capacity);
    EXPECT_FALSE(drawn.exceeded);
    EXPECT_EQ(drawn.capacity, capacity);
    EXPECT_EQ(drawn.instances, waited.instances);
    EXPECT_EQ(drawn.color, waited.color);
    if (GetParam() == SumOrder::kFixed) {
      EXPECT_EQ(drawn.d_position, waited.d_position);
    }
  }
}

// The background, no gradients, and no memory touched that there is not.
TEST_P(CapacityOf, TooLittleLeavesTheListsEmpty) {
  const test::ParityCase c = test::RandomCase("capacity", 200, 40, 24, Basis::kDcsh, 1);
  const size_t instances = Draw(c, GetParam(), nullptr).instances;
  for (const size_t capacity : {instances - 1, size_t(1), size_t(0)}) {
    const Drawn drawn = Draw(c, GetParam(), &capacity);
    EXPECT_TRUE(drawn.exceeded);
    EXPECT_EQ(drawn.instances, instances);
    const size_t plane = drawn.color.size() / 3;
    for (size_t i = 0; i < drawn.color.size(); ++i)
      ASSERT_EQ(drawn.color[i], c.settings.background[i / plane]);
    for (const float d : drawn.d_position) ASSERT_EQ(d, 0);
  }
}

TEST_F(Capacity, NothingDrawnFitsIntoAny) {
  test::ParityCase c = test::RandomCase("nothing", 40, 40, 24, Basis::kDcsh, 1);
  for (size_t i = 0; i < c.gaussians.size(); ++i) *c.gaussians.at(kOpacityLogit, i) = -20;
  for (const size_t capacity : {size_t(0), size_t(64)}) {
    const Drawn drawn = Draw(c, SumOrder::kFixed, &capacity);
    EXPECT_FALSE(drawn.exceeded);
    EXPECT_EQ(drawn.instances, 0u);
    for (const float d : drawn.d_position) ASSERT_EQ(d, 0);
  }
}

}  // namespace
}  // namespace cosplat
