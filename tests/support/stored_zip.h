// Writes ZIP archives whose members are stored as they are, as torch.save does.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "splat/base/files.h"

namespace cosplat::test {

inline void AppendLittleEndian(std::string& out, uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += char(value >> (8 * i) & 255);
}

// Members as (name, bytes). PKWARE's APPNOTE, 4.3.
inline std::string StoredZip(const std::vector<std::pair<std::string, std::string>>& members) {
  std::string archive, directory;
  for (const auto& [name, bytes] : members) {
    std::string common;  // the fields that both headers have
    AppendLittleEndian(common, 20, 2);
    AppendLittleEndian(common, 0, 4);           // flags, method: stored
    AppendLittleEndian(common, 0x00210000, 4);  // 1980-01-01
    AppendLittleEndian(common, Crc32(bytes.data(), bytes.size()), 4);
    AppendLittleEndian(common, uint32_t(bytes.size()), 4);
    AppendLittleEndian(common, uint32_t(bytes.size()), 4);
    AppendLittleEndian(common, uint32_t(name.size()), 4);  // and no extra field
    directory += "PK\1\2";
    AppendLittleEndian(directory, 20, 2);
    directory += common;
    AppendLittleEndian(directory, 0, 4);  // comment, disk
    AppendLittleEndian(directory, 0, 4);  // attributes
    AppendLittleEndian(directory, 0, 2);
    AppendLittleEndian(directory, uint32_t(archive.size()), 4);
    directory += name;
    archive += "PK\3\4";
    archive += common + name + bytes;
  }
  const uint32_t begin = uint32_t(archive.size());
  archive += directory + "PK\5\6";
  AppendLittleEndian(archive, 0, 4);
  AppendLittleEndian(archive, uint32_t(members.size()), 2);
  AppendLittleEndian(archive, uint32_t(members.size()), 2);
  AppendLittleEndian(archive, uint32_t(directory.size()), 4);
  AppendLittleEndian(archive, begin, 4);
  AppendLittleEndian(archive, 0, 2);
  return archive;
}

}  // namespace cosplat::test
