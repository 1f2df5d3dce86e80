#include "apps/cosplat/run/data_checksums.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>

#include "apps/cosplat/run/run_folder.h"
#include "splat/base/files.h"
#include "splat/train/subject/frame_reader.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

uint32_t ChecksumOf(const std::string& text, uint32_t before = 0) {
  return Crc32(text.data(), text.size(), before);
}

uint32_t ChecksumOf(const Image8& image, uint32_t before = 0) {
  const int size[3] = {image.width, image.height, image.channels};
  return Crc32(image.data.data(), image.data.size(), Crc32(size, sizeof size, before));
}

// `of(i)` for all i, in parallel.
template <class F>
void AddEach(size_t count, const F& of, DataChecksums& checksums) {
  const size_t first = checksums.size();
  checksums.resize(first + count);
  tbb::parallel_for(size_t(0), count, [&](size_t i) { checksums[first + i] = of(i); });
}

}  // namespace

void AddFrames(const std::string& kind,
               const std::vector<std::string>& names,
               const TrainFrame* frames,
               DataChecksums& checksums) {
  const auto of = [&](size_t i) {
    TrainFrame scratch;
    const TrainFrame& frame = Loaded(frames[i], scratch);
    uint32_t image = ChecksumOf(frame.target);
    if (!frame.ignored.empty()) image = ChecksumOf(frame.ignored, image);
    return std::pair(kind + " " + names[i],
                     ChecksumOf(CameraToJson(frames[i].camera).dump(), image));
  };
  AddEach(names.size(), of, checksums);
}

void AddTrack(const std::string& kind,
              const std::vector<TrackedFrame>& frames,
              DataChecksums& checksums) {
  const auto of = [&](size_t i) {
    const FlameParams& p = frames[i].params;
    const Json json{CameraToJson(frames[i].camera), p.expression, p.pose, p.translation};
    return std::pair(kind + " " + frames[i].name, ChecksumOf(json.dump()));
  };
  AddEach(frames.size(), of, checksums);
}

void AddImages(const std::string& kind,
               const std::vector<Image8>& images,
               DataChecksums& checksums) {
  const auto of = [&](size_t i) {
    return std::pair(kind + " " + std::to_string(i), ChecksumOf(images[i]));
  };
  AddEach(images.size(), of, checksums);
}

void AddGaussians(const std::string& name, const Gaussians& gaussians, DataChecksums& checksums) {
  uint32_t sum = 0;
  for (const Buffer<float>& values : gaussians.values)
    sum = Crc32(values.data(), values.size() * sizeof(float), sum);
  checksums.emplace_back(name, sum);
}

void AddText(const std::string& name, const std::string& text, DataChecksums& checksums) {
  checksums.emplace_back(name, ChecksumOf(text));
}

void AddFiles(const std::string& name, const std::string& path, DataChecksums& checksums) {
  if (path.empty()) return;
  std::vector<std::string> files;
  if (fs::is_directory(path)) {
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.is_regular_file()) files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
  } else {
    files.push_back(path);
  }
  uint32_t sum = 0;
  for (const std::string& file : files) sum = Crc32OfFile(file, sum);
  checksums.emplace_back(name, sum);
}

}  // namespace cosplat
