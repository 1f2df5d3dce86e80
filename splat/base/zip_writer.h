// Writing ZIP archives: .npz files, bundles of SOG. The counterpart of splat/base/zip_reader.h.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

struct ZipMember {
  std::string name;
  std::string bytes;
  bool compressed = true;  // deflated; false: stored, for what is compressed already
};

// In the order given, dated 1980, so that equal members give equal files. Atomic. Throws Error if
// the file cannot be written.
void WriteZip(const std::string& path, const std::vector<ZipMember>& members);

}  // namespace cosplat
