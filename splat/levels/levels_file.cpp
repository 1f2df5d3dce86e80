#include "splat/levels/levels_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "splat/base/crc32.h"
#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

constexpr char kLevelsMagic[8] = {'C', 'O', 'S', 'P', 'L', 'O', 'D', '\n'};
constexpr uint32_t kLevelsFormat = 1;
constexpr uint64_t kAlignment = 64;

struct LevelsHeader {
  char magic[8];
  uint32_t format, degree, basis, antialiased;
  uint64_t blocks;
};
struct StoredBlock {
  LevelBlock block;
  uint32_t crc;
};
static_assert(sizeof(LevelsHeader) == 32 && sizeof(StoredBlock) == 44);

uint64_t RoundedUp(uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

uint64_t TableBytes(uint64_t blocks) {
  return sizeof(LevelsHeader) + blocks * sizeof(StoredBlock) + sizeof(uint32_t);
}

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

// Blocks of a file, one by one: each a child of one other at most, which comes after it.
class BlockCheck {
 public:
  BlockCheck(const std::string& path, size_t blocks) : path_(path), has_parent_(blocks) {}

  void Add(size_t index, const LevelBlock& b) {
    const std::string name = "blocks[" + std::to_string(index) + "]";
    if (b.count < 1 || b.count > kLevelBlock)
      throw Error(
          path_,
          name + ".count",
          "is " + std::to_string(b.count) + ", expected 1 to " + std::to_string(kLevelBlock));
    if (b.children > 2 || uint64_t(b.first_child) + b.children > index)
      throw Error(path_, name + ".children", "are not blocks before it");
    for (uint32_t c = b.first_child; c < b.first_child + b.children; ++c) {
      if (has_parent_[c]) throw Error(path_, name + ".children", "belong to another block");
      has_parent_[c] = true;
    }
    bool sound = std::isfinite(b.coarseness) && b.coarseness >= 0;
    for (size_t k = 0; k < 3; ++k)
      sound =
          sound && std::isfinite(b.least[k]) && std::isfinite(b.most[k]) && b.least[k] <= b.most[k];
    if (!sound) throw Error(path_, name, "has no finite bounds");
  }

 private:
  const std::string& path_;
  std::vector<bool> has_parent_;
};

}  // namespace

bool IsLevelsFile(const std::string& path) {
  char magic[sizeof kLevelsMagic] = {};
  std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
  return std::memcmp(magic, kLevelsMagic, sizeof magic) == 0;
}

void WriteLevels(const std::string& path, const SceneLevels& levels) {
  LevelsHeader header = {};
  std::memcpy(header.magic, kLevelsMagic, sizeof kLevelsMagic);
  header.format = kLevelsFormat;
  header.degree = uint32_t(levels.layout.degree);
  header.basis = uint32_t(levels.layout.basis);
  header.antialiased = levels.layout.antialiased ? 1 : 0;
  header.blocks = levels.blocks.size();
  std::string table(reinterpret_cast<const char*>(&header), sizeof header);
  uint64_t floats = 0;
  for (size_t b = 0; b < levels.blocks.size(); ++b) {
    const uint64_t of_block = levels.blocks[b].count * levels.width();
    StoredBlock stored = {};
    stored.block = levels.blocks[b];
    stored.crc = Crc32(levels.ValuesOf(b), of_block * sizeof(float));
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
    throw Error(path, "format", "is " + std::to_string(header.format) + ", this program reads 1");
  if (header.blocks < 1 || header.blocks > file->size() / sizeof(StoredBlock) ||
      TableBytes(header.blocks) > file->size())
    throw Error(path, "blocks", "do not fit into the file: " + std::to_string(header.blocks));
  const uint64_t table = TableBytes(header.blocks) - sizeof(uint32_t);
  uint32_t crc = 0;
  std::memcpy(&crc, file->bytes() + table, sizeof crc);
  if (crc != Crc32(file->bytes(), table)) throw Error(path, "blocks", "are damaged");
  if (header.degree > uint32_t(kMaxTrainedDegree))
    throw Error(path, "degree", "is " + std::to_string(header.degree) + ", expected 0 to 4");
  if (header.basis >= kBasisNames.size())
    throw Error(path, "basis", "is " + std::to_string(header.basis) + ", which is none");

  SceneLevels levels;
  levels.layout.degree = int(header.degree);
  levels.layout.basis = Basis(header.basis);
  levels.layout.antialiased = header.antialiased != 0;
  BlockCheck check(path, header.blocks);
  for (size_t b = 0; b < header.blocks; ++b) {
    StoredBlock stored;
    std::memcpy(&stored, file->bytes() + sizeof header + b * sizeof stored, sizeof stored);
    check.Add(b, stored.block);
    levels.blocks.push_back(stored.block);
    levels.checksums.push_back(stored.crc);
  }
  levels.file = path;
  const uint64_t begin = RoundedUp(TableBytes(header.blocks));
  const uint64_t expected = begin + levels.FindOffsets() * sizeof(float);
  if (file->size() != expected)
    throw Error(
        path,
        "file",
        "has " + std::to_string(file->size()) + " bytes, expected " + std::to_string(expected));
  levels.values =
      std::shared_ptr<const float>(file, reinterpret_cast<const float*>(file->bytes() + begin));
  return levels;
}

}  // namespace cosplat
