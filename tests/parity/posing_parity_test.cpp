// FLAME posed on the device against FlamePoser: every kind of parameter, and what is shared.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "assets/head/procedural_head.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/play/rig_poser.h"
#include "avatar/surface/cuda/kernels.h"
#include "splat/device/cuda/stream.h"
#include "tests/flame/random_model.h"
#include "tests/parity/device_fixture.h"
#include "tests/support/restless_params.h"

namespace cosplat {
namespace {

class PosingParity : public test::DeviceTest {
 protected:
  PosingParity() { cuda::ProvideAvatarKernels(); }
};

// More vertices than a block has threads, more expressions than go by fours.
const FlameModel& Flame() {
  static const FlameModel model = test::RandomModel(300, 3, 13);
  return model;
}

FlameParams RandomParams(unsigned seed, float expression, float angle, float metres) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> normal;
  FlameParams p;
  for (int k = 0; k < Flame().expression_count; ++k)
    p.expression.push_back(expression * normal(rng));
  for (auto& joint : p.pose)
    for (float& x : joint) x = angle * normal(rng);
  for (float& x : p.translation) x = metres * normal(rng);
  return p;
}

// Both of one subject.
struct Posers {
  explicit Posers(const FlameModel& flame = Flame(), const std::optional<Bust>& bust = {})
      : host(flame, {0.7f, -1}, {}, bust),
        device({host.flame().Arrays(), host.bust(), host.bust_pivot()}, store, stream) {}

  std::vector<float> OnHost(const FlameParams& params) {
    std::vector<float> vertices;
    host.Forward(host.ParametersFor(params), vertices);
    return vertices;
  }
  std::vector<float> OnDevice(const FlameParams& params) {
    const AvatarPoser::Parameters parameters = host.ParametersFor(params);
    AvatarRig rig;
    host.flame().Prepare(parameters, rig.flame);
    rig.bust = parameters.bust;
    std::vector<float> vertices(3 * device.vertex_count());
    device.Pose(rig, stream).Download(vertices.data(), stream);
    stream.Wait();
    return vertices;
  }
  // Within a micrometre of a head, and in proportion of what is larger.
  void ExpectSame(const FlameParams& params) {
    const std::vector<float> cpu = OnHost(params), there = OnDevice(params);
    ASSERT_EQ(cpu.size(), there.size());
    float largest = 1;
    for (const float x : cpu) largest = std::max(largest, std::abs(x));
    for (size_t i = 0; i < cpu.size(); ++i)
      ASSERT_NEAR(cpu[i], there[i], 1e-6f * largest) << "number " << i;
  }

  cuda::CudaStream stream;
  DirectionStore store;
  AvatarPoser host;
  RigPoser device;
};

TEST_F(PosingParity, RandomFaces) {
  Posers posers;
  for (unsigned seed = 0; seed < 4; ++seed) posers.ExpectSame(RandomParams(seed, 1, 0.4f, 0.2f));
}

// As far as parameters may go.
TEST_F(PosingParity, ExtremeFaces) {
  Posers posers;
  posers.ExpectSame(RandomParams(1, 1000, 0.4f, 0.2f));
  posers.ExpectSame(RandomParams(2, 1, 100, 0.2f));
  posers.ExpectSame(RandomParams(3, 1e-6f, 1e-6f, 1000));
  FlameParams max = RandomParams(4, 1, 1, 1);
  for (float& x : max.expression) x = x < 0 ? -1e6f : 1e6f;
  for (auto& joint : max.pose) joint = {1e6f, -1e6f, 1e6f};
  max.translation = {1e6f, 1e6f, -1e6f};
  posers.ExpectSame(max);
}

TEST_F(PosingParity, AllZeroAndOneAtATime) {
  Posers posers;
  posers.ExpectSame({});
  for (int j = 0; j < kFlameJoints; ++j) {
    FlameParams params;
    params.pose[j] = {0.3f, -0.5f, 0.2f};
    posers.ExpectSame(params);
  }
  for (const size_t k : {0, 5, 12}) {
    FlameParams params;
    params.expression.assign(k + 1, 0.0f);
    params.expression[k] = 1.5f;
    posers.ExpectSame(params);
  }
}

// Those that are added by fours and the rest, with zeros between them; more than the model has are
// left out.
TEST_F(PosingParity, AnyNumberOfCoefficients) {
  Posers posers;
  for (size_t count = 1; count <= 15; count += 2) {
    FlameParams params;
    for (size_t k = 0; k < count; ++k)
      params.expression.push_back(k % 3 == 1 ? 0 : 0.2f * float(k) - 1);
    posers.ExpectSame(params);
  }
}

TEST_F(PosingParity, AHeadWithItsBust) {
  static const FlameModel head = MakeProceduralHead();
  Bust bust;
  bust.translation = {0.1f, -0.2f, 0.3f};
  Posers posers(head, bust);
  ASSERT_FALSE(posers.host.bust().empty());
  EXPECT_EQ(posers.device.vertex_count(), posers.host.vertex_count());
  for (const int frame : {1, 8}) posers.ExpectSame(test::RestlessParams(head, frame));
  BustFollow& follow = bust.follow.emplace();
  for (size_t i = 0; i < follow.matrix.size(); ++i) follow.matrix[i] = 0.1f * float(i % 7) - 0.3f;
  follow.min.fill(-0.2f);
  follow.max.fill(0.3f);
  Posers following(head, bust);
  for (const int frame : {1, 8}) {
    const FlameParams params = test::RestlessParams(head, frame);
    following.ExpectSame(params);
    EXPECT_NE(following.OnHost(params), posers.OnHost(params));
  }
}

TEST_F(PosingParity, KeepsNothingOfTheLastFace) {
  Posers posers;
  const FlameParams params = RandomParams(7, 1, 0.4f, 0.2f);
  const std::vector<float> first = posers.OnDevice(params);
  posers.OnDevice({});
  posers.OnDevice(RandomParams(8, 50, 2, 1));
  EXPECT_EQ(posers.OnDevice(params), first);
}

TEST_F(PosingParity, AModelsDirectionsAreThereOnce) {
  const FlameModel other = test::RandomModel(20, 3, 5);
  cuda::CudaStream stream;
  DirectionStore store;
  const FlamePoser<float> poser(Flame(), {}), twin(Flame(), {1}), stranger(other, {});
  auto directions = store.Get(poser.Arrays(), stream);
  EXPECT_EQ(directions, store.Get(twin.Arrays(), stream));
  EXPECT_NE(directions, store.Get(stranger.Arrays(), stream));
  const std::weak_ptr<const PosingDirections> gone = directions;
  directions.reset();
  EXPECT_TRUE(gone.expired()) << "nobody poses by it";
  EXPECT_EQ(store.Get(poser.Arrays(), stream)->pose.size(), Flame().pose_directions.size());
}

}  // namespace
}  // namespace cosplat
