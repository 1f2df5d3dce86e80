#include "splat/base/state_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <ostream>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

static_assert(std::endian::native == std::endian::little, "the file has the memory's byte order");

constexpr std::array<char, 8> kStateMagic{'C', 'O', 'S', 'P', 'L', 'A', 'T', '\n'};
constexpr const char* kHeaderField = "header";

class StateWriter : public StateArchive {
 public:
  StateWriter(const std::string& path, std::ostream& out) : path_(path), out_(out) {}

  bool reads() const override { return false; }
  void Fail(const std::string& name, const std::string& problem) const override {
    throw Error(path_, name, problem);
  }
  void Bytes(const std::string& name, void* bytes, size_t size) override {
    const uint32_t length = uint32_t(name.size());
    const uint64_t count = size;
    Put(&length, sizeof length);
    Put(name.data(), name.size());
    Put(&count, sizeof count);
    Put(bytes, size);
  }
  void Put(const void* bytes, size_t size) {
    crc_ = Crc32(bytes, size, crc_);
    out_.write(static_cast<const char*>(bytes), std::streamsize(size));
    if (!out_ && problem_ == 0) problem_ = errno;
  }
  uint32_t crc() const { return crc_; }
  // errno of the first write that failed; what is done between writes has others.
  int problem() const { return problem_; }

 private:
  void CheckSize(const std::string&, size_t, size_t) const override {}

  const std::string& path_;
  std::ostream& out_;
  uint32_t crc_ = 0;
  int problem_ = 0;
};

class StateDiscarder : public StateArchive {
 public:
  bool reads() const override { return false; }
  void Fail(const std::string& name, const std::string& problem) const override {
    throw Error("state", name, problem);
  }

 private:
  void Bytes(const std::string&, void*, size_t) override {}
  void CheckSize(const std::string&, size_t, size_t) const override {}
};

// The fields of [begin, end) in order.
class StateReader : public StateArchive {
 public:
  StateReader(const std::string& path, const char* begin, const char* end)
      : path_(path), next_(begin), end_(end) {}

  bool reads() const override { return true; }
  void Fail(const std::string& name, const std::string& problem) const override {
    throw Error(path_, name, problem);
  }
  void Bytes(const std::string& name, void* bytes, size_t size) override {
    const Field field = Next(name);
    if (field.size != size) Fail(name, Format("has {} bytes, expected {}", field.size, size));
    if (size != 0) std::memcpy(bytes, field.bytes, size);
    next_ = field.bytes + size;
  }
  std::string Text(const std::string& name) {
    const Field field = Next(name);
    next_ = field.bytes + field.size;
    return {field.bytes, field.size};
  }
  const char* next() const { return next_; }

 private:
  struct Field {
    const char* bytes;
    size_t size;
  };

  void CheckSize(const std::string& name, size_t count, size_t element) const override {
    const Field field = Next(name);
    if (field.size / element != count || field.size % element != 0)
      Fail(name, Format("has {} elements, expected {}", field.size / element, count));
  }

  Field Next(const std::string& expected) const {
    const char* at = next_;
    const auto take = [&](void* to, size_t size) {
      if (size_t(end_ - at) < size) Fail(expected, "is missing: the file ends before it");
      std::memcpy(to, at, size);
      at += size;
    };
    uint32_t length = 0;
    uint64_t size = 0;
    take(&length, sizeof length);
    std::string name(std::min(size_t(length), size_t(end_ - at)), '\0');
    take(name.data(), name.size());
    if (name != expected) Fail(expected, "expected, found '" + name + "'");
    take(&size, sizeof size);
    if (size > size_t(end_ - at)) Fail(expected, "is longer than the file");
    return {at, size_t(size)};
  }

  const std::string& path_;
  const char* next_;
  const char* end_;
};

}  // namespace

void WriteStateFile(const std::string& path,
                    const std::string& header,
                    const StateDescription& describe) {
  WriteFileDurably(path, [&](std::ostream& out) {
    StateWriter writer(path, out);
    const uint32_t format = kStateFormat;
    writer.Put(kStateMagic.data(), kStateMagic.size());
    writer.Put(&format, sizeof format);
    writer.Bytes(kHeaderField, const_cast<char*>(header.data()), header.size());
    describe(writer);
    const uint32_t crc = writer.crc();
    writer.Put(&crc, sizeof crc);
    if (writer.problem() != 0) errno = writer.problem();
  });
}

void DiscardState(const StateDescription& describe) {
  StateDiscarder archive;
  describe(archive);
}

StateFile::StateFile(const std::string& path) : path_(path), bytes_(ReadFile(path)) {
  constexpr size_t kMagic = kStateMagic.size(), kStart = kMagic + sizeof(uint32_t);
  if (bytes_.size() < kStart || !std::equal(kStateMagic.begin(), kStateMagic.end(), bytes_.begin()))
    throw Error(path, "is not a checkpoint, or it is damaged at its beginning");
  uint32_t format = 0, stored = 0;
  std::memcpy(&format, bytes_.data() + kMagic, sizeof format);
  if (bytes_.size() < kStart + sizeof stored) throw Error(path, "is incomplete");
  end_ = bytes_.size() - sizeof stored;
  std::memcpy(&stored, bytes_.data() + end_, sizeof stored);
  // Before the format, which may be what is damaged.
  if (stored != Crc32(bytes_.data(), end_))
    throw Error(path, "is damaged: its checksum does not match");
  if (format != kStateFormat)
    throw Error(path, Format("has format {}, this program reads format {}", format, kStateFormat));
  StateReader reader(path_, bytes_.data() + kStart, bytes_.data() + end_);
  header_ = reader.Text(kHeaderField);
  fields_ = size_t(reader.next() - bytes_.data());
}

void StateFile::Read(const StateDescription& describe) const {
  StateReader reader(path_, bytes_.data() + fields_, bytes_.data() + end_);
  describe(reader);
  if (reader.next() != bytes_.data() + end_)
    throw Error(path_, "has more fields than this program reads");
}

}  // namespace cosplat
