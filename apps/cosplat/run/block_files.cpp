#include "apps/cosplat/run/block_files.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/train/blocks/block_schedule.h"
#include "splat/train/serialize_state.h"

namespace cosplat {
namespace {

constexpr const char* kGaussians = ".bin";
constexpr const char* kRecord = ".record.bin";

std::string BlocksFolder(const std::string& run_folder) { return run_folder + "/blocks"; }

void Serialize(StateArchive& a, BlockRecord& record) {
  a.Value("round", record.round);
  a.Value("gaussians", record.gaussians);
  a.Value("cost", record.cost);
  uint64_t exposed = record.exposures.value.size() / math::kExposureNumbers;
  a.Value("exposed", exposed);
  Serialize(a, exposed, record.exposures);
}

}  // namespace

RoundCost& RoundCost::operator+=(const RoundCost& other) {
  steps += other.steps;
  ignored += other.ignored;
  seconds += other.seconds;
  cpu_seconds += other.cpu_seconds;
  ms_per_step = other.ms_per_step;
  times += other.times;
  return *this;
}

BlockFiles::BlockFiles(const std::string& run_folder, const Gaussians& layout)
    : folder_(BlocksFolder(run_folder)), layout_(layout) {}

std::string BlockFiles::PathOf(size_t block, const std::string& suffix) const {
  const std::string name = block == kWholeScene ? "whole" : std::to_string(block + 1);
  return folder_ + "/" + name + suffix;
}

std::string BlockFiles::LayerPath(size_t block, size_t view, LayerKind kind) const {
  constexpr const char* kSuffixes[] = {
      ".rgba", ".front.rgba", ".behind.rgba", ".target.rgba", ".ignored"};
  return PathOf(block, "/" + std::to_string(view) + kSuffixes[size_t(kind)]);
}

std::string BlockFiles::CheckpointPath(size_t block, uint32_t round) const {
  return PathOf(block, ".round-" + std::to_string(round) + ".bin");
}

void BlockFiles::WriteLayer(size_t block, size_t view, LayerKind kind, const Image8& layer) const {
  MakeDirectories(PathOf(block, ""));
  WriteFileAtomically(LayerPath(block, view, kind), [&](std::ostream& out) {
    // A file without a byte is one that was lost, with the machine's power.
    if (layer.empty()) out.put(0);
    out.write(reinterpret_cast<const char*>(layer.data.data()), std::streamsize(layer.data.size()));
  });
}

void BlockFiles::RemoveLayer(size_t block, size_t view, LayerKind kind) const {
  RemoveFile(LayerPath(block, view, kind));
}

Image8 BlockFiles::ReadLayer(size_t block,
                             size_t view,
                             LayerKind kind,
                             const Camera& camera) const {
  const std::string path = LayerPath(block, view, kind);
  const std::vector<char> bytes = ReadFile(path);
  if (bytes.size() == 1) return {};
  Image8 layer(camera.width, camera.height, kind == LayerKind::kIgnored ? 1 : 4);
  if (bytes.size() != layer.data.size())
    throw Error(path, Format("has {} bytes, expected {}", bytes.size(), layer.data.size()));
  std::copy(bytes.begin(), bytes.end(), layer.data.begin());
  return layer;
}

void BlockFiles::WriteBlock(size_t block,
                            const Gaussians& gaussians,
                            const BlockRecord& record) const {
  WriteStateFile(PathOf(block, kGaussians), "", [&](StateArchive& a) {
    uint64_t count = gaussians.size();
    a.Value("count", count);
    Serialize(a, "gaussians", count, const_cast<Gaussians&>(gaussians));  // only written
  });
  WriteStateFile(PathOf(block, kRecord), "", [&](StateArchive& a) {
    Serialize(a, const_cast<BlockRecord&>(record));  // only written
  });
}

Gaussians BlockFiles::ReadBlock(size_t block) const {
  Gaussians gaussians = layout_;
  StateFile(PathOf(block, kGaussians)).Read([&](StateArchive& a) {
    uint64_t count = 0;
    a.Value("count", count);
    Serialize(a, "gaussians", count, gaussians);
  });
  return gaussians;
}

Gaussians BlockFiles::ReadBlocks(const std::vector<uint32_t>& blocks) const {
  size_t count = 0;
  for (const uint32_t b : blocks) count += ReadRecord(b).gaussians;
  Gaussians all = layout_;
  for (int a = 0; a < kAttributeCount; ++a) all.values[a].reserve(count * size_t(all.width(a)));
  for (const uint32_t b : blocks) all.Append(ReadBlock(b));
  return all;
}

BlockRecord BlockFiles::ReadRecord(size_t block) const {
  BlockRecord record;
  StateFile(PathOf(block, kRecord)).Read([&](StateArchive& a) { Serialize(a, record); });
  return record;
}

void BlockFiles::RemoveWhole() const {
  RemoveFile(PathOf(kWholeScene, kGaussians));
  RemoveFile(PathOf(kWholeScene, kRecord));
}

void BlockFiles::Make(const std::string& run_folder) { MakeDirectories(BlocksFolder(run_folder)); }

void BlockFiles::Remove(const std::string& run_folder) {
  std::error_code code;
  std::filesystem::remove_all(BlocksFolder(run_folder), code);
  if (code) throw Error(BlocksFolder(run_folder), "cannot be removed: " + code.message());
}

void BlockState::Serialize(StateArchive& a, size_t frames, bool has_exposures) {
  a.Value("round", round);
  a.Value("cost", cost);
  a.Require(round <= kBlockRounds, "round", "is beyond the run's end");
  if (round == 0) return;
  cosplat::Serialize(a, counts.size(), blocks);
  for (auto& of_block : views) {
    a.ArrayUpTo("views", of_block, frames);
    for (const uint32_t view : of_block)
      a.Require(view < frames, "views", "names one that is not there");
  }
  a.Array("counts", counts, counts.size());
  if (has_exposures) cosplat::Serialize(a, frames, exposures);
}

}  // namespace cosplat
