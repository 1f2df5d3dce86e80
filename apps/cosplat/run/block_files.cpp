#include "apps/cosplat/run/block_files.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/train/describe_state.h"

namespace cosplat {
namespace {

std::string BlocksFolder(const std::string& run_folder) { return run_folder + "/blocks"; }

}  // namespace

BlockFiles::BlockFiles(const std::string& run_folder, const Gaussians& layout)
    : folder_(BlocksFolder(run_folder)), layout_(layout) {}

void BlockFiles::RemoveWhole() const { RemoveFile(folder_ + "/whole.bin"); }

std::string BlockFiles::LayerPath(size_t block, size_t view) const {
  return folder_ + "/" + NameOf(block) + "/" + std::to_string(view) + ".rgba";
}

void BlockFiles::WriteLayer(size_t block, size_t view, const Image8& layer) const {
  MakeDirectories(folder_ + "/" + NameOf(block));
  WriteFileAtomically(LayerPath(block, view), [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(layer.data.data()), std::streamsize(layer.data.size()));
  });
}

Image8 BlockFiles::ReadLayer(size_t block, size_t view, const Camera& camera) const {
  const std::string path = LayerPath(block, view);
  const std::vector<char> bytes = ReadFile(path);
  Image8 layer(camera.width, camera.height, 4);
  if (bytes.size() != layer.data.size())
    throw Error(path,
                "has " + std::to_string(bytes.size()) + " bytes, expected " +
                    std::to_string(layer.data.size()));
  std::copy(bytes.begin(), bytes.end(), layer.data.begin());
  return layer;
}

void BlockFiles::Write(const std::string& name, const Gaussians& gaussians) const {
  WriteStateFile(folder_ + "/" + name + ".bin", "", [&](StateArchive& a) {
    uint64_t count = gaussians.size();
    a.Value("count", count);
    Describe(a, "gaussians", count, const_cast<Gaussians&>(gaussians));  // only written
  });
}

Gaussians BlockFiles::Read(const std::string& name) const {
  Gaussians gaussians = layout_;
  StateFile(folder_ + "/" + name + ".bin").Read([&](StateArchive& a) {
    uint64_t count = 0;
    a.Value("count", count);
    Describe(a, "gaussians", count, gaussians);
  });
  return gaussians;
}

void BlockFiles::Make(const std::string& run_folder) { MakeDirectories(BlocksFolder(run_folder)); }

void BlockFiles::Remove(const std::string& run_folder) {
  std::error_code code;
  std::filesystem::remove_all(BlocksFolder(run_folder), code);
  if (code) throw Error(BlocksFolder(run_folder), "cannot be removed: " + code.message());
}

}  // namespace cosplat
