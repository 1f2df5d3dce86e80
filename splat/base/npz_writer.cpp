// Npz::Write: the one part of .npz files that needs libzip itself, not only ZipReader.
#include "splat/base/npz.h"
#include "splat/base/zip_writer.h"

namespace cosplat {

void Npz::Write(const std::string& path) const {
  std::vector<ZipMember> members;
  for (const auto& [name, array] : arrays_) members.push_back({name + ".npy", FormatNpy(array)});
  WriteZip(path, members);
}

}  // namespace cosplat
