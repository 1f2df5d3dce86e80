// The posed surface and the embedding on the device against the CPU's, forward and back.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "avatar/surface/binding.h"
#include "avatar/surface/cuda/kernels.h"
#include "avatar/train/posed_vertices.h"
#include "splat/device/cuda/stream.h"
#include "tests/avatar/meshes.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

class BindingParity : public test::DeviceTest {
 protected:
  BindingParity() { cuda::ProvideAvatarKernels(); }
};

struct BindingCase {
  std::string name;
  AvatarModel avatar;
  std::vector<float> posed;  // [V, 3]
};

std::vector<float> Wavy(const CanonicalMesh& mesh) {
  auto vertices = test::Turned(mesh.vertices, {0, 0.6f, 0.8f}, 2.3);
  for (size_t i = 0; i < vertices.size(); ++i) vertices[i] += 0.04f * std::sin(float(3 * i));
  return vertices;
}

BindingCase CaseOn(const std::string& name, const CanonicalMesh& mesh, size_t count) {
  return {name, test::RandomAvatar(mesh, count, unsigned(count + 1)), Wavy(mesh)};
}

// Vertices of face f at one place.
void Collapse(const CanonicalMesh& mesh, size_t f, std::vector<float>& vertices) {
  for (int c = 1; c < 3; ++c)
    for (int k = 0; k < 3; ++k)
      vertices[3 * mesh.faces[f][c] + k] = vertices[3 * mesh.faces[f][0] + k];
}

std::vector<BindingCase> Cases() {
  const CanonicalMesh ball = test::SphereMesh(2), sheet = test::SheetMesh(5, 1, 0.2f, 3);
  std::vector<BindingCase> cases;
  cases.push_back(CaseOn("closed", ball, 300));
  cases.push_back(CaseOn("with a boundary", sheet, 300));
  cases.push_back(CaseOn("two parts", test::Joined(ball, sheet), 100));
  cases.push_back(CaseOn("of a head's size", test::Scaled(ball, 0.1f), 200));
  cases.push_back(CaseOn("one Gaussian", ball, 1));
  cases.push_back(CaseOn("none", ball, 0));
  cases.push_back(CaseOn("all on one face", ball, 200));
  std::fill(cases.back().avatar.embedding.triangle.begin(),
            cases.back().avatar.embedding.triangle.end(),
            7);
  cases.push_back(CaseOn("collapsed faces", ball, 300));
  for (size_t f = 0; f < 20; f += 5) Collapse(ball, f, cases.back().posed);
  cases.push_back(CaseOn("all in one place", ball, 50));
  std::fill(cases.back().posed.begin(), cases.back().posed.end(), 0.25f);
  cases.push_back(CaseOn("grown beyond the limit", ball, 50));
  for (float& x : cases.back().posed) x *= 40;
  return cases;
}

// What a stream makes of a case, with the same random gradients in all of them.
struct Results {
  PosedGaussians posed;
  Gaussians d_gaussians;
  Buffer<float> d_vertices;
};

PosedGaussians RandomGradients(size_t n) {
  std::mt19937 rng(4);
  std::normal_distribution<float> normal(0, 0.3f);
  PosedGaussians d;
  d.Resize(n);
  for (Buffer<float>* b : {&d.position, &d.rotation, &d.scale_log, &d.frame})
    for (float& x : *b) x = normal(rng);
  return d;
}

// A case in a stream's memory, which is used again from run to run.
struct InStream {
  InStream(const BindingCase& c, Stream& stream) : stream(stream), surface(c.avatar.mesh, stream) {
    Send(c);
  }

  void Send(const BindingCase& c) {
    gaussians.Upload(c.avatar.gaussians, stream);
    UploadEmbedding(c.avatar.embedding, embedding, stream);
    vertices.Upload(c.posed.data(), c.posed.size(), stream);
    stream.Wait();
    scratch.by_face.Forget();
  }

  Results Run(bool with_frame = true) {
    const size_t n = gaussians.size();
    surface.Pose(vertices);
    Bind(gaussians, embedding, surface, posed);
    const PosedGaussians d = RandomGradients(n);
    d_posed.position.Upload(d.position.data(), 3 * n, stream);
    d_posed.rotation.Upload(d.rotation.data(), 4 * n, stream);
    d_posed.scale_log.Upload(d.scale_log.data(), 3 * n, stream);
    d_posed.frame.Upload(d.frame.data(), with_frame ? 4 * n : 0, stream);
    BindBackward(gaussians, embedding, surface, d_posed, d_gaussians, &d_vertices, scratch);
    Results r;
    Fetch(posed.position, r.posed.position);
    Fetch(posed.rotation, r.posed.rotation);
    Fetch(posed.scale_log, r.posed.scale_log);
    Fetch(posed.frame, r.posed.frame);
    for (const int a : {kPosition, kRotation, kScaleLog})
      Fetch(d_gaussians.values[a], r.d_gaussians.values[a]);
    Fetch(d_vertices, r.d_vertices);
    stream.Wait();
    return r;
  }

  void Fetch(const Buffer<float>& from, Buffer<float>& to) {
    to.resize(from.size());
    from.Download(to.data(), stream);
  }

  Stream& stream;
  Surface surface;
  Gaussians gaussians, d_gaussians;
  Embedding embedding;
  BindScratch scratch;
  PosedGaussians posed, d_posed;
  Buffer<float> vertices, d_vertices;
};

Results OnCpu(const BindingCase& c, bool with_frame = true) {
  return InStream(c, HostStream()).Run(with_frame);
}
Results OnDevice(const BindingCase& c, bool with_frame = true) {
  cuda::CudaStream stream;
  return InStream(c, stream).Run(with_frame);
}

// Of numbers of order 1 that go through some dozens of operations (the packs' own tests have the
// same bound).
void ExpectNear(View<const float> cpu, View<const float> device, const std::string& what) {
  ASSERT_EQ(cpu.size(), device.size()) << what;
  for (size_t i = 0; i < cpu.size(); ++i)
    ASSERT_NEAR(cpu[i], device[i], 4e-6f * (1 + std::abs(cpu[i]))) << what << " at " << i;
}

// Derivatives of blends that nearly cancel are worse off, few as they are.
const test::ParityTolerance kGradients = [] {
  test::ParityTolerance tolerance;
  tolerance.relative = 1e-4;
  return tolerance;
}();

// At vertices of faces whose area is rounding, so is the gradient: the direction of a cross product
// of two equal edges, which is zero or not as a compiler fuses it. It is finite, and not compared.
void ForgetCollapsedFaces(const BindingCase& c, Buffer<float>& d_vertices) {
  CanonicalMesh mesh = c.avatar.mesh;
  mesh.vertices = c.posed;
  for (const float x : d_vertices) ASSERT_TRUE(std::isfinite(x));
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    if (FaceArea(mesh, f) < 1e-6)
      for (const int32_t v : mesh.faces[f]) std::fill_n(d_vertices.begin() + 3 * v, 3, 0.0f);
}

void ExpectSame(const Results& cpu, const Results& device) {
  ExpectNear(cpu.posed.position, device.posed.position, "position");
  ExpectNear(cpu.posed.rotation, device.posed.rotation, "rotation");
  ExpectNear(cpu.posed.scale_log, device.posed.scale_log, "scale");
  ExpectNear(cpu.posed.frame, device.posed.frame, "frame");
  const char* names[] = {"d_offset", "d_rotation", "d_scale"};
  const int attributes[] = {kPosition, kRotation, kScaleLog};
  for (int k = 0; k < 3; ++k)
    ExpectSameGradients(cpu.d_gaussians.values[attributes[k]],
                        device.d_gaussians.values[attributes[k]],
                        kGradients,
                        names[k]);
  ExpectSameGradients(cpu.d_vertices, device.d_vertices, kGradients, "d_vertices");
}

TEST_F(BindingParity, ForwardAndBack) {
  for (const BindingCase& c : Cases()) {
    SCOPED_TRACE(c.name);
    Results cpu = OnCpu(c), device = OnDevice(c);
    ForgetCollapsedFaces(c, cpu.d_vertices);
    ForgetCollapsedFaces(c, device.d_vertices);
    ExpectSame(cpu, device);
  }
}

TEST_F(BindingParity, WithoutAGradientOfTheFrame) {
  const BindingCase c = CaseOn("closed", test::SphereMesh(2), 100);
  ExpectSame(OnCpu(c, false), OnDevice(c, false));
}

// No sum depends on the order of blocks, and memory that is used again leaves no trace.
TEST_F(BindingParity, GivesTheSameBits) {
  cuda::CudaStream stream;
  InStream device(CaseOn("closed", test::SphereMesh(2), 300), stream);
  const Results first = device.Run();
  for (int run = 0; run < 4; ++run) {
    const Results again = device.Run();
    EXPECT_EQ(first.posed.position, again.posed.position);
    EXPECT_EQ(first.d_vertices, again.d_vertices);
    for (const int a : {kPosition, kRotation, kScaleLog})
      EXPECT_EQ(first.d_gaussians.values[a], again.d_gaussians.values[a]);
  }
}

// What walking and density control leave: other triangles, another count.
TEST_F(BindingParity, FollowsAnEmbeddingThatChanges) {
  cuda::CudaStream stream;
  InStream device(CaseOn("closed", test::SphereMesh(2), 300), stream);
  device.Run();
  const BindingCase c = CaseOn("fewer", test::SphereMesh(2), 120);
  device.Send(c);
  ExpectSame(OnCpu(c), device.Run());
}

// Which way is up on a face without area is rounding, so that no Gaussian may be on one.
void LeaveCollapsedFaces(BindingCase& c) {
  CanonicalMesh mesh = c.avatar.mesh;
  mesh.vertices = c.posed;
  int32_t good = 0;
  while (size_t(good) + 1 < mesh.faces.size() && FaceArea(mesh, size_t(good)) < 1e-6) ++good;
  for (int32_t& f : c.avatar.embedding.triangle)
    if (FaceArea(mesh, size_t(f)) < 1e-6) f = good;
}

TEST_F(BindingParity, OfTheRigidRule) {
  for (BindingCase& c : Cases()) {
    SCOPED_TRACE(c.name);
    c.avatar.embedding.rigid = true;
    LeaveCollapsedFaces(c);
    const auto bound = [&](Stream& stream) {
      InStream in(c, stream);
      Results r;
      in.surface.Pose(in.vertices);
      Bind(in.gaussians, in.embedding, in.surface, in.posed);
      in.Fetch(in.posed.position, r.posed.position);
      in.Fetch(in.posed.scale_log, r.posed.scale_log);
      stream.Wait();
      return r;
    };
    cuda::CudaStream device;
    const Results a = bound(HostStream()), b = bound(device);
    ExpectNear(a.posed.position, b.posed.position, "position");
    ExpectNear(a.posed.scale_log, b.posed.scale_log, "scale");
  }
}

TEST_F(BindingParity, RefusesTheReleasedRule) {
  cuda::CudaStream stream;
  Embedding embedding, released;
  released.released.emplace();
  test::ExpectError([&] { UploadEmbedding(released, embedding, stream); }, {"released", "CPU"});
}

// Frames within the limit are posed once, those beyond each time.
TEST_F(BindingParity, KeepsPosedVerticesWithinALimit) {
  constexpr size_t kVertices = 5, kFrames = 4, kFrameBytes = 3 * kVertices * sizeof(float);
  cuda::CudaStream stream;
  PosedVertices posed(kFrames, kVertices, 2 * kFrameBytes + 1);
  EXPECT_EQ(posed.kept_frames(), 2u);
  std::vector<int> calls(kFrames);
  for (int pass = 0; pass < 3; ++pass)
    for (size_t frame = 0; frame < kFrames; ++frame) {
      const std::vector<float> vertices(3 * kVertices, float(frame));
      const auto pose = [&]() -> const std::vector<float>& {
        ++calls[frame];
        return vertices;
      };
      const View<const float> row = posed.Of(frame, pose, stream);
      ASSERT_EQ(row.count, 3 * kVertices);
      Readback<float> last(stream);
      EXPECT_EQ(last.Get(row.data + row.count - 1, stream), float(frame));
    }
  EXPECT_EQ(calls, (std::vector<int>{1, 1, 3, 3}));
  EXPECT_GE(posed.allocated_bytes(), 3 * kFrameBytes);
}

}  // namespace
}  // namespace cosplat
