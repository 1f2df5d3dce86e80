// Walking and re-embedding on the device against the CPU's, from the same places.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "avatar/surface/cuda/device_walk.h"
#include "avatar/surface/kernels/place.h"
#include "avatar/train/cuda/device_placement.h"
#include "splat/device/cuda/stream.h"
#include "tests/avatar/meshes.h"
#include "tests/parity/device_fixture.h"

namespace cosplat {
namespace {

class WalkParity : public test::DeviceTest {};

// A sheet with faces of no area in its middle and along its boundary.
CanonicalMesh Collapsed() {
  CanonicalMesh mesh = test::SheetMesh(6, 1, 0.2f, 4);
  for (const size_t f : {0, 30, 31, 50})
    for (int k = 0; k < 3; ++k)
      mesh.vertices[3 * mesh.faces[f][1] + k] = mesh.vertices[3 * mesh.faces[f][0] + k];
  return mesh;
}

struct WalkCase {
  std::string name;
  CanonicalMesh mesh;
  float step;  // standard deviation of du and dv
  int cap;     // of a boundary's face
};

std::vector<WalkCase> Cases() {
  const CanonicalMesh ball = test::SphereMesh(2, 0.1f), sheet = test::SheetMesh(5, 0.2f, 0.2f, 3);
  return {{"closed", ball, 1, 64},
          {"with a boundary", sheet, 1, 64},
          {"far, over boundaries", sheet, 20, 64},
          {"turned away at the boundary", sheet, 2, 4},
          {"two parts", test::Joined(ball, sheet), 0.3f, 3},
          {"faces of no area", Collapsed(), 2, 5},
          {"one face", test::SheetMesh(1), 1, 2}};
}

// Where a walk begins: some are not pushed, some have steps that no walk can take.
AvatarModel Start(const WalkCase& c, size_t count) {
  AvatarModel avatar = test::RandomAvatar(c.mesh, count, 7);
  std::mt19937 rng(8);
  std::normal_distribution<float> normal(0, c.step);
  for (size_t i = 0; i < count; ++i) {
    float* step = &avatar.gaussians.values[kPosition][3 * i];
    for (int k = 0; k < 2; ++k) step[k] = i % 9 == 0 ? 0 : normal(rng);
    if (i % 50 == 1) step[i % 2] = NAN;
    if (i % 50 == 2) step[0] = 1e6f;
    if (i % 50 == 3) avatar.barycentric[i] = {1.4f, -0.2f};  // outside
  }
  return avatar;
}

struct OnDevice {
  cuda::Stream stream;
  cuda::DeviceMesh mesh;
  cuda::DeviceEmbedding embedding;
  cuda::DeviceBuffer<float> position;

  OnDevice(const Surface& surface, const AvatarModel& avatar) : mesh(surface, stream.get()) {
    embedding.Upload(avatar, surface.faces().size(), stream.get());
    Send(avatar);
  }
  void Send(const AvatarModel& avatar) {
    const Buffer<float>& p = avatar.gaussians.values[kPosition];
    position.Upload(p.data(), p.size(), stream.get());
  }
  void Fetch(AvatarModel& to) {
    embedding.Download(to, stream.get());
    position.Download(to.gaussians.values[kPosition].data(), stream.get());
    stream.Wait();
  }
};

// In float; walks are in double, whose rounding may differ by the device.
void ExpectSamePlaces(const AvatarModel& device, const AvatarModel& cpu, const std::string& name) {
  ASSERT_EQ(device.triangle, cpu.triangle) << name;
  for (size_t i = 0; i < cpu.triangle.size(); ++i) {
    for (int k = 0; k < 2; ++k)
      ASSERT_NEAR(device.barycentric[i][k], cpu.barycentric[i][k], 1e-6f) << name << " " << i;
    for (int k = 0; k < 3; ++k) {
      const float expected = cpu.gaussians.values[kPosition][3 * i + k];
      const float actual = device.gaussians.values[kPosition][3 * i + k];
      if (std::isfinite(expected))
        ASSERT_NEAR(actual, expected, 1e-6f * (1 + std::abs(expected))) << name << " " << i;
      else
        ASSERT_FALSE(std::isfinite(actual)) << name << " " << i;
    }
  }
}

std::vector<uint8_t> OutcomesOf(const WalkReport& report, size_t count) {
  std::vector<uint8_t> outcomes(count, 0);
  for (const uint32_t i : report.crossed) outcomes[i] |= cuda::DeviceWalk::kCrossed;
  for (const uint32_t i : report.stopped_at_boundary) outcomes[i] |= cuda::DeviceWalk::kStopped;
  for (const uint32_t i : report.invalid) outcomes[i] |= cuda::DeviceWalk::kInvalid;
  return outcomes;
}

TEST_F(WalkParity, EndsWhereItEndsOnTheCpu) {
  int seen[8] = {};
  for (const WalkCase& c : Cases()) {
    const Surface surface(c.mesh);
    AvatarModel cpu = Start(c, 400), back = cpu;
    OnDevice device(surface, cpu);
    cuda::DeviceWalk walk;
    // Again from where the last ended, with the same push.
    const Buffer<float> push = cpu.gaussians.values[kPosition];
    for (int round = 0; round < 3; ++round) {
      cpu.gaussians.values[kPosition] = push;
      device.Send(cpu);
      walk.Walk(device.mesh, c.cap, device.embedding, device.position, device.stream.get());
      const std::vector<float> ones(push.size(), 1.0f);
      cuda::DeviceBuffer<float> moment;
      moment.Upload(ones.data(), ones.size(), device.stream.get());
      walk.ResetMoment(moment, device.stream.get());
      std::vector<uint8_t> outcomes(cpu.triangle.size());
      std::vector<float> left(ones.size());
      walk.outcomes().Download(outcomes.data(), device.stream.get());
      moment.Download(left.data(), device.stream.get());
      device.Fetch(back);
      const WalkReport report = WalkAll(cpu, surface, c.cap);
      ExpectSamePlaces(back, cpu, c.name);
      ASSERT_EQ(outcomes, OutcomesOf(report, cpu.triangle.size())) << c.name;
      for (size_t i = 0; i < outcomes.size(); ++i) {
        ++seen[outcomes[i]];
        for (int k = 0; k < 3; ++k)
          ASSERT_EQ(left[3 * i + k], outcomes[i] && k < 2 ? 0.0f : 1.0f) << c.name << " " << i;
      }
    }
  }
  using Walk = cuda::DeviceWalk;
  for (const int outcome : {0,
                            int(Walk::kCrossed),
                            int(Walk::kStopped),
                            Walk::kCrossed | Walk::kStopped,
                            int(Walk::kInvalid)})
    EXPECT_GT(seen[outcome], 50) << outcome;
}

TEST_F(WalkParity, NobodyToWalk) {
  const WalkCase c{"none", test::SphereMesh(1), 1, 64};
  const Surface surface(c.mesh);
  OnDevice device(surface, Start(c, 0));
  cuda::DeviceWalk walk;
  walk.Walk(device.mesh, c.cap, device.embedding, device.position, device.stream.get());
  device.stream.Wait();
  EXPECT_TRUE(walk.outcomes().empty());
}

// Offsets of a few faces' width, and some that lead nowhere.
std::vector<float> Offsets(size_t count) {
  std::mt19937 rng(9);
  std::normal_distribution<float> normal(0, 0.05f);
  std::vector<float> offsets;
  for (size_t i = 0; i < 3 * count; ++i) offsets.push_back(normal(rng));
  for (size_t c = 0; c < count; c += 40) offsets[3 * c + 1] = NAN;
  for (size_t c = 5; c < count; c += 40) offsets[3 * c] = 1e30f;
  return offsets;
}

TEST_F(WalkParity, ChildrenAreEmbeddedWhereTheyAreOnTheCpu) {
  for (const bool keeps_d : {false, true})
    for (const WalkCase& c : Cases()) {
      const size_t count = 1500, first = 100;  // more than search at a time
      const Surface surface(c.mesh);
      AvatarModel cpu = Start(c, count), back = cpu;
      for (float& x : cpu.gaussians.values[kPosition]) x *= 0.1f;
      OnDevice device(surface, cpu);
      cuda::DevicePlacement placement;
      const std::vector<float> offsets = Offsets(count - first);
      cuda::DeviceBuffer<float> sent;
      sent.Upload(offsets.data(), offsets.size(), device.stream.get());
      placement.Move(device.mesh,
                     std::as_const(sent).view(),
                     first,
                     keeps_d,
                     device.embedding,
                     device.position,
                     device.stream.get());
      device.Fetch(back);
      math::FaceSearch search;
      for (size_t i = first; i < count; ++i) {
        const float* by = &offsets[3 * (i - first)];
        math::MoveOnMesh(
            surface.CanonicalArrays(),
            {by[0], by[1], by[2]},
            keeps_d,
            {&cpu.triangle[i], cpu.barycentric[i].data(), &cpu.gaussians.values[kPosition][3 * i]},
            search);
      }
      ExpectSamePlaces(back, cpu, c.name);
    }
}

TEST_F(WalkParity, CentersAndRatesAreTheCpus) {
  const WalkCase c = Cases()[4];
  const Surface surface(c.mesh);
  const AvatarModel cpu = Start(c, 300);
  OnDevice device(surface, cpu);
  std::vector<float> rate_of_face(c.mesh.faces.size());
  for (size_t f = 0; f < rate_of_face.size(); ++f) rate_of_face[f] = 1 + float(f);
  cuda::DevicePlacement placement;
  cuda::DeviceBuffer<float> sent, rates;
  sent.Upload(rate_of_face.data(), rate_of_face.size(), device.stream.get());
  const auto centers =
      placement.Centers(device.mesh, device.embedding, device.position, device.stream.get());
  placement.Rates(std::as_const(sent).view(), device.embedding, rates, device.stream.get());
  std::vector<float> got_centers(centers.count), got_rates(rates.size());
  cudaMemcpyAsync(got_centers.data(),
                  centers.data,
                  centers.count * sizeof(float),
                  cudaMemcpyDeviceToHost,
                  device.stream.get());
  rates.Download(got_rates.data(), device.stream.get());
  device.stream.Wait();
  ASSERT_EQ(got_centers.size(), 900u);
  ASSERT_EQ(got_rates.size(), 900u);
  for (size_t i = 0; i < 300; ++i) {
    const auto p = math::CanonicalPlace(surface.CanonicalArrays(),
                                        cpu.triangle[i],
                                        cpu.barycentric[i].data(),
                                        &cpu.gaussians.values[kPosition][3 * i]);
    const float expected[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; ++k) {
      if (std::isfinite(expected[k]))
        EXPECT_NEAR(got_centers[3 * i + k], expected[k], 1e-6f * (1 + std::abs(expected[k]))) << i;
      else
        EXPECT_FALSE(std::isfinite(got_centers[3 * i + k])) << i;
      EXPECT_EQ(got_rates[3 * i + k], k == 2 ? 1.0f : rate_of_face[size_t(cpu.triangle[i])]);
    }
  }
}

}  // namespace
}  // namespace cosplat
