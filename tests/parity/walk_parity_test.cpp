// Walking and re-embedding on the device against the CPU's, from the same places.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "avatar/surface/cuda/kernels.h"
#include "avatar/surface/kernels/place.h"
#include "avatar/surface/walk.h"
#include "splat/device/cuda/stream.h"
#include "splat/device/for_each.h"
#include "tests/avatar/meshes.h"
#include "tests/parity/device_fixture.h"

namespace cosplat {
namespace {

class WalkParity : public test::DeviceTest {
 protected:
  WalkParity() { cuda::ProvideAvatarKernels(); }
};

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

// Where a walk begins: some are not pushed, some have a step that is no number, a very long one, or
// begin outside of their triangle.
AvatarModel Start(const WalkCase& c, size_t count) {
  AvatarModel avatar = test::RandomAvatar(c.mesh, count, 7);
  std::mt19937 rng(8);
  std::normal_distribution<float> normal(0, c.step);
  for (size_t i = 0; i < count; ++i) {
    float* step = &avatar.gaussians.values[kPosition][3 * i];
    for (int k = 0; k < 2; ++k) step[k] = i % 9 == 0 ? 0 : normal(rng);
    if (i % 50 == 1) step[i % 2] = NAN;
    if (i % 50 == 2) step[0] = 50;                                     // across the whole mesh
    if (i % 50 == 3) avatar.embedding.barycentric[i] = {1.4f, -0.2f};  // outside
  }
  return avatar;
}

struct OnDevice {
  cuda::CudaStream stream;
  Surface surface;
  Embedding embedding;
  Buffer<float> position;
  FaceLists by_face;

  explicit OnDevice(const AvatarModel& avatar) : surface(avatar.mesh, stream) {
    UploadEmbedding(avatar.embedding, embedding, stream);
    Send(avatar);
  }
  void Send(const AvatarModel& avatar) {
    const Buffer<float>& p = avatar.gaussians.values[kPosition];
    position.Upload(p.data(), p.size(), stream);
    stream.Wait();
  }
  void Fetch(AvatarModel& to) {
    embedding.triangle.Download(to.embedding.triangle.data(), stream);
    embedding.barycentric.Download(to.embedding.barycentric.data(), stream);
    position.Download(to.gaussians.values[kPosition].data(), stream);
    stream.Wait();
  }
};

// One in a hundred may end beside an edge on the other triangle: rounding decides there.
size_t MayDiffer(size_t count) { return count / 100; }

// Offsets and barycentrics are floats, walks are in double. With multiplications and additions
// fused on one side alone (tests/cuda), the largest difference is below 1e-6.
constexpr float kTolerance = 4e-6f;

void ExpectSamePlaces(const AvatarModel& device,
                      const AvatarModel& cpu,
                      const Surface& surface,
                      const std::string& name) {
  size_t differ = 0;
  const auto place = [&](const AvatarModel& avatar, size_t i) {
    return math::CanonicalPlace(surface.CanonicalArrays(),
                                avatar.embedding.triangle[i],
                                avatar.embedding.barycentric[i].data(),
                                &avatar.gaussians.values[kPosition][3 * i]);
  };
  for (size_t i = 0; i < cpu.embedding.triangle.size(); ++i) {
    if (device.embedding.triangle[i] != cpu.embedding.triangle[i]) {
      ++differ;
      const auto a = place(device, i), b = place(cpu, i);
      ASSERT_NEAR(a.x, b.x, 1e-5f) << name << " " << i;
      ASSERT_NEAR(a.y, b.y, 1e-5f) << name << " " << i;
      ASSERT_NEAR(a.z, b.z, 1e-5f) << name << " " << i;
      continue;
    }
    for (int k = 0; k < 2; ++k)
      ASSERT_NEAR(device.embedding.barycentric[i][k], cpu.embedding.barycentric[i][k], kTolerance)
          << name << " " << i;
    for (int k = 0; k < 3; ++k) {
      const float expected = cpu.gaussians.values[kPosition][3 * i + k];
      const float actual = device.gaussians.values[kPosition][3 * i + k];
      if (std::isfinite(expected))
        ASSERT_NEAR(actual, expected, kTolerance * (1 + std::abs(expected))) << name << " " << i;
      else
        ASSERT_FALSE(std::isfinite(actual)) << name << " " << i;
    }
  }
  ASSERT_LE(differ, MayDiffer(cpu.embedding.triangle.size())) << name;
}

std::vector<uint8_t> OutcomesOf(const WalkReport& report, size_t count) {
  std::vector<uint8_t> outcomes(count, 0);
  for (const uint32_t i : report.crossed) outcomes[i] |= kWalkCrossed;
  for (const uint32_t i : report.stopped_at_boundary) outcomes[i] |= kWalkStopped;
  for (const uint32_t i : report.invalid) outcomes[i] |= kWalkInvalid;
  return outcomes;
}

TEST_F(WalkParity, EndsWhereItEndsOnTheCpu) {
  int seen[8] = {};
  for (const WalkCase& c : Cases()) {
    const Surface surface(c.mesh);
    AvatarModel cpu = Start(c, 400), back = cpu;
    OnDevice device(cpu);
    TriangleWalk walk;
    // Again from where the last ended, with the same push.
    const Buffer<float> push = cpu.gaussians.values[kPosition];
    for (int round = 0; round < 3; ++round) {
      cpu.gaussians.values[kPosition] = push;
      device.Send(cpu);
      walk.Run(device.surface, c.cap, device.by_face, device.embedding, device.position);
      const std::vector<float> ones(push.size(), 1.0f);
      Buffer<float> moment;
      moment.Upload(ones.data(), ones.size(), device.stream);
      walk.ResetMoment(moment, device.stream);
      std::vector<uint8_t> outcomes(cpu.embedding.triangle.size());
      std::vector<float> left(ones.size());
      walk.outcomes().Download(outcomes.data(), device.stream);
      moment.Download(left.data(), device.stream);
      device.Fetch(back);
      const WalkReport report = WalkAll(cpu, surface, c.cap);
      ExpectSamePlaces(back, cpu, surface, c.name);
      const std::vector<uint8_t> expected = OutcomesOf(report, outcomes.size());
      size_t differ = 0;
      for (size_t i = 0; i < outcomes.size(); ++i) differ += outcomes[i] != expected[i];
      ASSERT_LE(differ, MayDiffer(outcomes.size())) << c.name;
      for (size_t i = 0; i < outcomes.size(); ++i) {
        ++seen[outcomes[i]];
        for (int k = 0; k < 3; ++k)
          ASSERT_EQ(left[3 * i + k], outcomes[i] && k < 2 ? 0.0f : 1.0f) << c.name << " " << i;
      }
    }
  }
  for (const int outcome :
       {0, int(kWalkCrossed), int(kWalkStopped), kWalkCrossed | kWalkStopped, int(kWalkInvalid)})
    EXPECT_GT(seen[outcome], 50) << outcome;
}

TEST_F(WalkParity, NobodyToWalk) {
  const WalkCase c{"none", test::SphereMesh(1), 1, 64};
  OnDevice device(Start(c, 0));
  TriangleWalk walk;
  walk.Run(device.surface, c.cap, device.by_face, device.embedding, device.position);
  device.stream.Wait();
  EXPECT_TRUE(walk.outcomes().empty());
}

// Offsets of a few faces' width, some that lead nowhere, and some far away from the mesh.
std::vector<float> Offsets(size_t count) {
  std::mt19937 rng(9);
  std::normal_distribution<float> normal(0, 0.05f);
  std::vector<float> offsets;
  for (size_t i = 0; i < 3 * count; ++i) offsets.push_back(normal(rng));
  for (size_t c = 0; c < count; c += 40) offsets[3 * c + 1] = NAN;
  for (size_t c = 5; c < count; c += 40) offsets[3 * c] = 3;
  return offsets;
}

TEST_F(WalkParity, ChildrenAreEmbeddedWhereTheyAreOnTheCpu) {
  for (const bool keeps_d : {false, true})
    for (const WalkCase& c : Cases()) {
      const size_t count = 1500, first = 100, searchers = 1024;  // more than search at a time
      const Surface surface(c.mesh);
      AvatarModel cpu = Start(c, count), back = cpu;
      for (float& x : cpu.gaussians.values[kPosition]) x *= 0.1f;
      OnDevice device(cpu);
      const std::vector<float> offsets = Offsets(count - first);
      Buffer<float> sent;
      Buffer<math::FaceSearch> searches;
      sent.Upload(offsets.data(), offsets.size(), device.stream);
      searches.Refill(searchers, device.stream);
      ForEach(searchers,
              device.stream,
              MoveEach{device.surface.CanonicalArrays(),
                       sent.view(),
                       first,
                       keeps_d,
                       searches.view(),
                       device.embedding.triangle.data(),
                       device.embedding.barycentric_data(),
                       device.position.view()});
      device.Fetch(back);
      math::FaceSearch search;
      for (size_t i = first; i < count; ++i) {
        const float* by = &offsets[3 * (i - first)];
        math::MoveOnMesh(surface.CanonicalArrays(),
                         {by[0], by[1], by[2]},
                         keeps_d,
                         {&cpu.embedding.triangle[i],
                          cpu.embedding.barycentric[i].data(),
                          &cpu.gaussians.values[kPosition][3 * i]},
                         search);
      }
      ExpectSamePlaces(back, cpu, surface, c.name);
    }
}

TEST_F(WalkParity, CentersAndRatesAreTheCpus) {
  const WalkCase c = Cases()[4];
  const Surface surface(c.mesh);
  const AvatarModel cpu = Start(c, 300);
  OnDevice device(cpu);
  Stream& stream = device.stream;
  std::vector<float> rate_of_face(c.mesh.faces.size());
  for (size_t f = 0; f < rate_of_face.size(); ++f) rate_of_face[f] = 1 + float(f);
  Buffer<float> sent, rates, centers;
  sent.Upload(rate_of_face.data(), rate_of_face.size(), stream);
  centers.Refill(900, stream);
  rates.Refill(900, stream);
  ForEach(300,
          stream,
          PlaceEach{device.surface.CanonicalArrays(),
                    device.embedding.triangle.data(),
                    device.embedding.barycentric_data(),
                    device.position.view(),
                    centers.view()});
  ForEach(300, stream, RateEach{sent.view(), device.embedding.triangle.data(), rates.view()});
  std::vector<float> got_centers(900), got_rates(900);
  centers.Download(got_centers.data(), stream);
  rates.Download(got_rates.data(), stream);
  stream.Wait();
  for (size_t i = 0; i < 300; ++i) {
    const auto p = math::CanonicalPlace(surface.CanonicalArrays(),
                                        cpu.embedding.triangle[i],
                                        cpu.embedding.barycentric[i].data(),
                                        &cpu.gaussians.values[kPosition][3 * i]);
    const float expected[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; ++k) {
      if (std::isfinite(expected[k]))
        EXPECT_NEAR(got_centers[3 * i + k], expected[k], kTolerance * (1 + std::abs(expected[k])))
            << i;
      else
        EXPECT_FALSE(std::isfinite(got_centers[3 * i + k])) << i;
      EXPECT_EQ(got_rates[3 * i + k],
                k == 2 ? 1.0f : rate_of_face[size_t(cpu.embedding.triangle[i])]);
    }
  }
}

}  // namespace
}  // namespace cosplat
