// WriteZip and Npz::Write where there is no libzip: the WebAssembly build. Members are stored, not
// deflated. Source: PKWARE, .ZIP File Format Specification 6.3.10, sections 4.3.7, 4.3.12, 4.3.16.
#include <limits>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/base/state_file.h"
#include "splat/base/zip_archive.h"

namespace cosplat {
namespace {

constexpr uint32_t kLocalHeader = 0x04034b50, kCentralHeader = 0x02014b50, kEnd = 0x06054b50;
constexpr uint16_t kVersion = 20, kUtf8 = 1 << 11;
constexpr uint16_t k1980 = 1 << 5 | 1;  // its first day

class Bytes {
 public:
  Bytes& U16(size_t value) { return Put(value, 2); }
  Bytes& U32(size_t value) { return Put(value, 4); }
  Bytes& Text(const std::string& text) {
    bytes_ += text;
    return *this;
  }
  const std::string& get() const { return bytes_; }

 private:
  Bytes& Put(size_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_ += char(value >> 8 * i & 0xff);
    return *this;
  }
  std::string bytes_;
};

// What a local and a central header have alike.
void PutMember(const ZipMember& member, Bytes& out) {
  const size_t size = member.bytes.size();
  out.U16(kVersion).U16(kUtf8).U16(0).U16(0).U16(k1980);
  out.U32(Crc32(member.bytes.data(), size, 0)).U32(size).U32(size);
  out.U16(member.name.size()).U16(0);
}

}  // namespace

void WriteZip(const std::string& path, const std::vector<ZipMember>& members) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    Bytes directory;
    size_t at = 0;
    for (const ZipMember& member : members) {
      Bytes header;
      PutMember(member, header.U32(kLocalHeader));
      header.Text(member.name);
      file.write(header.get().data(), std::streamsize(header.get().size()));
      file.write(member.bytes.data(), std::streamsize(member.bytes.size()));
      PutMember(member, directory.U32(kCentralHeader).U16(kVersion));
      directory.U16(0).U16(0).U16(0).U32(0).U32(at).Text(member.name);
      at += header.get().size() + member.bytes.size();
      if (at > std::numeric_limits<uint32_t>::max())
        throw Error(path, member.name, "is too large for an archive");
    }
    Bytes end;
    end.U32(kEnd).U16(0).U16(0).U16(members.size()).U16(members.size());
    end.U32(directory.get().size()).U32(at).U16(0);
    file << directory.get() << end.get();
  });
}

void Npz::Write(const std::string& path) const {
  std::vector<ZipMember> members;
  for (const auto& [name, array] : arrays_) members.push_back({name + ".npy", FormatNpy(array)});
  WriteZip(path, members);
}

}  // namespace cosplat
