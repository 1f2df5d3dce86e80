// The CPU back end: project -> tile lists -> blend per tile, in parallel with oneTBB. Results are
// bit-identical for any number of threads: tiles and Gaussians are independent, and a Gaussian's
// gradient is the sum of its tiles' records in a fixed order.
#include <tbb/parallel_for.h>

#include "splat/config.h"
#include "splat/render/cpu/blend_tile.h"
#include "splat/render/cpu/launch.h"
#include "splat/render/rasterizer.h"

namespace cosplat {
namespace {

class CpuTape : public RenderTape {
 public:
  const InstanceCounts* counts() const override { return &drawn; }
  size_t capacity() const override { return lists.entries.size(); }
  std::vector<MemoryPart> Memory() const override {
    return {{"projected splats", AllocatedBytes(splats, radius)},
            {"tile lists", lists.GaussianBytes()},
            {"gradients per splat and tile", AllocatedBytes(blended, records, contributions)},
            {"gradients per splat", AllocatedBytes(d_splats)},
            {"tiles", lists.TileBytes() + AllocatedBytes(n_contrib), MemoryOf::kPixels}};
  }

  ViewParameters view{};
  RenderSettings settings;
  TileLists lists;
  InstanceCounts drawn;
  Buffer<uint32_t> n_contrib;          // [tiles] entries processed before the tile was opaque
  Buffer<uint32_t> blended;            // [instances] of TileJob
  Buffer<SplatGradient> records;       // [instances]
  Buffer<Contribution> contributions;  // [instances]; allocated on first use
};

class CpuRasterizer : public StagedRasterizer {
 public:
  Stream& stream() override { return HostStream(); }
  std::unique_ptr<RenderTape> MakeTape(bool) const override { return std::make_unique<CpuTape>(); }

  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings,
               RenderedImage& image,
               RenderTape& base_tape) override {
    auto& tape = static_cast<CpuTape&>(base_tape);
    CheckArguments(gaussians, camera, settings);
    tape.view = ViewOfCamera(camera, basis, settings.degree);
    tape.splats.resize(gaussians.count);
    tape.radius.resize(gaussians.count);
    {
      ScopedPhase phase(times, Phase::kProject);
      LaunchProject(gaussians, tape.view, tape.splats.data(), tape.radius.data());
    }
    Draw(camera, settings, image, tape);
  }

  void Project(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               int degree,
               ProjectedSplat* splats,
               float* radii) override {
    ScopedPhase phase(times, Phase::kProject);
    LaunchProject(gaussians, ViewOfCamera(camera, basis, degree), splats, radii);
  }

  void Draw(const Camera& camera,
            const RenderSettings& settings,
            RenderedImage& image,
            RenderTape& base_tape) override {
    auto& tape = static_cast<CpuTape&>(base_tape);
    tape.settings = settings;
    {
      ScopedPhase phase(times, Phase::kSort);
      tape.lists.Build(tape.splats, tape.radius, camera.width, camera.height);
      tape.drawn = {tape.lists.entries.size(), tape.lists.order.size()};
    }
    ScopedPhase phase(times, Phase::kBlend);
    image.width = camera.width;
    image.height = camera.height;
    image.color.resize(3 * size_t(camera.width) * camera.height);
    image.transmittance.resize(size_t(camera.width) * camera.height);
    const int tiles = tape.lists.tiles_x * tape.lists.tiles_y;
    tape.n_contrib.resize(tiles);
    tape.blended.Refill(tape.lists.entries.size());
    tbb::parallel_for(0, tiles, [&](int tile) {
      TileJob job = JobOf(tape, tile, image.width, image.height);
      job.color = image.color.data();
      job.transmittance = image.transmittance.data();
      tape.n_contrib[tile] = BlendTileForward(job);
    });
  }

  void Backward(const WorldGaussians& gaussians,
                const RenderedImage& image,
                const Buffer<float>& d_color,
                RenderTape& base_tape,
                const WorldGradients& gradients) override {
    DrawBackward(image, d_color, base_tape);
    ScopedPhase phase(times, Phase::kBackward);
    auto& tape = static_cast<CpuTape&>(base_tape);
    LaunchProjectVjp(gaussians,
                     tape.view,
                     tape.splats.data(),
                     tape.radius.data(),
                     tape.d_splats.data(),
                     gradients);
  }

  void DrawBackward(const RenderedImage& image,
                    const Buffer<float>& d_color,
                    RenderTape& base_tape) override {
    ScopedPhase phase(times, Phase::kBackward);
    auto& tape = static_cast<CpuTape&>(base_tape);
    tape.records.Refill(tape.lists.entries.size());
    const int tiles = tape.lists.tiles_x * tape.lists.tiles_y;
    tbb::parallel_for(0, tiles, [&](int tile) {
      TileJob job = JobOf(tape, tile, image.width, image.height);
      job.color = const_cast<float*>(image.color.data());  // read only here
      for (uint32_t k = tape.n_contrib[tile]; k < job.entry_count; ++k)
        tape.records[job.entries[k].record] = SplatGradient{};
      job.entry_count = tape.n_contrib[tile];
      BlendTileBackward(job, d_color.data(), tape.records.data());
    });
    SumRecords(tape);
  }

  void ProjectBackward(const WorldGaussians& gaussians,
                       Basis basis,
                       const Camera& camera,
                       int degree,
                       const ProjectedSplat* splats,
                       const float* radii,
                       const SplatGradient* d_splats,
                       const WorldGradients& gradients) override {
    ScopedPhase phase(times, Phase::kBackward);
    LaunchProjectVjp(
        gaussians, ViewOfCamera(camera, basis, degree), splats, radii, d_splats, gradients);
  }

  void Contributions(const RenderedImage& image,
                     RenderTape& base_tape,
                     Buffer<Contribution>& sums) override {
    auto& tape = static_cast<CpuTape&>(base_tape);
    const TileLists& lists = tape.lists;
    tape.contributions.assign(lists.entries.size(), Contribution{});
    tbb::parallel_for(0, lists.tiles_x * lists.tiles_y, [&](int tile) {
      TileJob job = JobOf(tape, tile, image.width, image.height);
      job.color = const_cast<float*>(image.color.data());  // read only here
      job.entry_count = tape.n_contrib[tile];
      SumContributions(job, tape.contributions.data());
    });
    sums.assign(tape.splats.size(), Contribution{});
    tbb::parallel_for(size_t(0), lists.order.size(), [&](size_t k) {
      Contribution& sum = sums[lists.order[k]];
      for (uint32_t r = lists.record_begin[k]; r < lists.record_begin[k + 1]; ++r)
        sum += tape.contributions[r];
    });
  }

 private:
  static TileJob JobOf(CpuTape& tape, int tile, int width, int height) {
    TileJob job;
    job.splats = tape.splats.data();
    job.entries = tape.lists.entries.data() + tape.lists.tile_begin[tile];
    job.entry_count = tape.lists.tile_begin[tile + 1] - tape.lists.tile_begin[tile];
    job.blended = tape.blended.data() + tape.lists.tile_begin[tile];
    job.x0 = tile % tape.lists.tiles_x * kTileSize;
    job.y0 = tile / tape.lists.tiles_x * kTileSize;
    job.width = width;
    job.height = height;
    for (int c = 0; c < 3; ++c) job.background[c] = tape.settings.background[c];
    job.exp_degree = tape.settings.exp_degree;
    return job;
  }

  // Sums each Gaussian's records over its instances in a fixed order.
  static void SumRecords(CpuTape& tape) {
    tape.d_splats.resize(tape.splats.size());
    const TileLists& lists = tape.lists;
    tbb::parallel_for(size_t(0), lists.order.size(), [&](size_t k) {
      SplatGradient sum{};
      for (uint32_t r = lists.record_begin[k]; r < lists.record_begin[k + 1]; ++r)
        sum += tape.records[r];
      tape.d_splats[lists.order[k]] = sum;
    });
  }
};

}  // namespace

std::unique_ptr<StagedRasterizer> MakeCpuRasterizer() { return std::make_unique<CpuRasterizer>(); }

}  // namespace cosplat
