#include "splat/levels/levels_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

constexpr char kLevelsMagic[8] = {'C', 'O', 'S', 'P', 'L', 'O', 'D', '\n'};
constexpr uint32_t kLevelsFormat = 1;
constexpr uint64_t kAlignment = 64;
// Values of LevelsHeader::antialiased, which is 0 without.
constexpr uint32_t kOurLowPass = 1, kOthersLowPass = 2;

struct LevelsHeader {
  char magic[8];
  uint32_t format, degree, basis, antialiased;
  uint64_t gaussians;
};
struct StoredBlock {
  std::array<float, 3> min, max;
  float coarseness;
  uint32_t crc;
};
static_assert(sizeof(LevelsHeader) == 32 && sizeof(StoredBlock) == 32);

uint64_t RoundedUp(uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

// A file in memory, for reading.
class Mapping {
 public:
  explicit Mapping(const std::string& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) throw Error(path, "file", std::strerror(errno));
    struct stat status = {};
    const bool known = fstat(file, &status) == 0 && status.st_size > 0;
    if (known) {
      size_ = size_t(status.st_size);
      data_ = mmap(nullptr, size_, PROT_READ, MAP_SHARED, file, 0);
    }
    const int problem = errno;
    close(file);
    if (!known) throw Error(path, "file", "is empty");
    if (data_ == MAP_FAILED) throw Error(path, "file", std::strerror(problem));
  }
  ~Mapping() { munmap(data_, size_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  const char* bytes() const { return static_cast<const char*>(data_); }
  size_t size() const { return size_; }

 private:
  void* data_ = MAP_FAILED;
  size_t size_ = 0;
};

bool HasFiniteBounds(const StoredBlock& b) {
  bool finite = std::isfinite(b.coarseness) && b.coarseness >= 0;
  for (size_t k = 0; k < 3; ++k)
    finite = finite && std::isfinite(b.min[k]) && std::isfinite(b.max[k]) && b.min[k] <= b.max[k];
  return finite;
}

}  // namespace

bool IsLevelsFile(const std::string& path) {
  char magic[sizeof kLevelsMagic] = {};
  std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
  return std::memcmp(magic, kLevelsMagic, sizeof magic) == 0;
}

void WriteLevels(const std::string& path, const SceneLevels& levels) {
  if (levels.blocks.empty()) throw Error(path, "scene", "has no Gaussian that can be seen");
  LevelsHeader header = {};
  std::memcpy(header.magic, kLevelsMagic, sizeof kLevelsMagic);
  header.format = kLevelsFormat;
  header.degree = uint32_t(levels.layout.degree);
  header.basis = uint32_t(levels.layout.basis);
  if (levels.layout.antialiased)
    header.antialiased =
        levels.layout.low_pass_variance == kBlurVariance ? kOthersLowPass : kOurLowPass;
  header.gaussians = levels.size();
  std::string table(reinterpret_cast<const char*>(&header), sizeof header);
  uint64_t floats = 0;
  for (size_t b = 0; b < levels.blocks.size(); ++b) {
    const LevelBlock& block = levels.blocks[b];
    const uint64_t of_block = block.count * levels.width();
    const StoredBlock stored{block.min,
                             block.max,
                             block.coarseness,
                             Crc32(levels.ValuesOf(b), of_block * sizeof(float))};
    table.append(reinterpret_cast<const char*>(&stored), sizeof stored);
    floats += of_block;
  }
  const uint32_t crc = Crc32(table.data(), table.size());
  table.append(reinterpret_cast<const char*>(&crc), sizeof crc);
  table.resize(RoundedUp(table.size()), '\0');
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.write(table.data(), std::streamsize(table.size()));
    out.write(reinterpret_cast<const char*>(levels.values.get()),
              std::streamsize(floats * sizeof(float)));
  });
}

SceneLevels OpenLevels(const std::string& path) {
  const auto file = std::make_shared<const Mapping>(path);
  LevelsHeader header = {};
  if (file->size() < sizeof header) throw Error(path, "file", "ends in its header");
  std::memcpy(&header, file->bytes(), sizeof header);
  if (std::memcmp(header.magic, kLevelsMagic, sizeof kLevelsMagic) != 0)
    throw Error(path, "file", "holds no levels of detail");
  if (header.format != kLevelsFormat)
    throw Error(path,
                "format",
                "is " + std::to_string(header.format) + ", this program reads " +
                    std::to_string(kLevelsFormat));
  if (header.degree > uint32_t(kMaxTrainedDegree))
    throw Error(path,
                "degree",
                "is " + std::to_string(header.degree) + ", expected 0 to " +
                    std::to_string(kMaxTrainedDegree));
  if (header.basis >= kBasisNames.size())
    throw Error(path, "basis", "is " + std::to_string(header.basis) + ", which is none");
  if (header.antialiased > kOthersLowPass)
    throw Error(
        path, "antialiased", "is " + std::to_string(header.antialiased) + ", expected 0 to 2");

  SceneLevels levels;
  levels.layout.degree = int(header.degree);
  levels.layout.basis = Basis(header.basis);
  levels.layout.antialiased = header.antialiased != 0;
  if (header.antialiased == kOthersLowPass) levels.layout.low_pass_variance = kBlurVariance;
  if (header.gaussians < 1 || header.gaussians > file->size() / (levels.width() * sizeof(float)))
    throw Error(path, "gaussians", "do not fit into the file: " + std::to_string(header.gaussians));
  const uint64_t floats = levels.LayOut(header.gaussians);
  const uint64_t table = sizeof header + levels.blocks.size() * sizeof(StoredBlock);
  const uint64_t begin = RoundedUp(table + sizeof(uint32_t));
  const uint64_t expected = begin + floats * sizeof(float);
  if (file->size() != expected)
    throw Error(
        path,
        "file",
        "has " + std::to_string(file->size()) + " bytes, expected " + std::to_string(expected));
  uint32_t crc = 0;
  std::memcpy(&crc, file->bytes() + table, sizeof crc);
  if (crc != Crc32(file->bytes(), table)) throw Error(path, "blocks", "are damaged");
  for (size_t b = 0; b < levels.blocks.size(); ++b) {
    StoredBlock stored;
    std::memcpy(&stored, file->bytes() + sizeof header + b * sizeof stored, sizeof stored);
    if (!HasFiniteBounds(stored))
      throw Error(path, "blocks[" + std::to_string(b) + "]", "has no finite bounds");
    LevelBlock& block = levels.blocks[b];
    block.min = stored.min;
    block.max = stored.max;
    block.coarseness = stored.coarseness;
    levels.checksums.push_back(stored.crc);
  }
  levels.file = path;
  levels.values =
      std::shared_ptr<const float>(file, reinterpret_cast<const float*>(file->bytes() + begin));
  return levels;
}

}  // namespace cosplat
