#include <filesystem>

#include "flame/io/pickle.h"
#include "splat/base/error.h"
#include "splat/base/zip_archive.h"

namespace cosplat {
namespace {

constexpr char kPickleName[] = "data.pkl";

// The folder of the archive that holds everything, with a '/' at the end, or empty.
std::string RootOf(const std::string& path, const ZipReader& archive) {
  for (size_t i = 0; i < archive.size(); ++i) {
    const std::string name = archive.Name(i);
    if (name == kPickleName || name.ends_with(std::string("/") + kPickleName))
      return name.substr(0, name.size() - (sizeof(kPickleName) - 1));
  }
  throw Error(path, kPickleName, "is missing: this is no file of torch.save");
}

}  // namespace

Pickle ReadTorchFile(const std::string& path) {
  const ZipReader archive(path, "a file of torch.save (a ZIP archive)");
  // torch stores members as they are, so that none is larger than the file.
  const uint64_t limit = std::filesystem::file_size(path);
  const std::string root = RootOf(path, archive);
  const auto read = [&](const std::string& member) {
    const size_t index = archive.Find(root + member);
    if (index == archive.size()) throw Error(path, root + member, "is missing");
    return archive.Read(index, limit);
  };
  if (archive.Find(root + "byteorder") != archive.size()) {
    const std::vector<char> order = read("byteorder");
    if (std::string(order.begin(), order.end()) != "little")
      throw Error(path, root + "byteorder", "is not little");
  }
  return Pickle(path + " " + root + kPickleName, read(kPickleName), [&](const std::string& key) {
    return read("data/" + key);
  });
}

}  // namespace cosplat
