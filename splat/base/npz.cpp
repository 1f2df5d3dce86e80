#include "splat/base/npz.h"

#include <utility>

#include "splat/base/error.h"
#include "splat/base/zip_archive.h"

namespace cosplat {
namespace {

// A negative extent is any.
template <class T>
std::string ShapeText(const std::vector<T>& shape) {
  std::string text = "[";
  for (size_t i = 0; i < shape.size(); ++i)
    text += (i ? ", " : "") + (std::cmp_less(shape[i], 0) ? "*" : std::to_string(shape[i]));
  return text + "]";
}

template <class T>
NpyArray MakeArray(const std::string& path,
                   const std::string& name,
                   std::vector<size_t> shape,
                   const std::vector<T>& values,
                   const char* dtype) {
  size_t count = 1;
  for (size_t extent : shape) count *= extent;
  if (count != values.size())
    throw Error(path,
                name,
                "has " + std::to_string(values.size()) + " values, its shape " + ShapeText(shape) +
                    " needs " + std::to_string(count));
  return {std::move(shape), std::vector<double>(values.begin(), values.end()), dtype};
}

}  // namespace

Npz Npz::Read(const std::string& path) { return Read(path, ZipReader(path, ".npz")); }

Npz Npz::Parse(const std::string& path, std::vector<char> bytes) {
  return Read(path, ZipReader(path, ".npz", std::move(bytes)));
}

Npz Npz::Read(const std::string& path, const ZipReader& archive) {
  Npz npz;
  npz.path_ = path;
  for (size_t i = 0; i < archive.size(); ++i) {
    const std::string name = archive.Name(i);
    if (!name.ends_with(".npy")) continue;
    NpyArray array;
    if (ParseNpy(path, name, archive.Read(i), array))
      npz.arrays_[name.substr(0, name.size() - 4)] = std::move(array);
  }
  return npz;
}

const NpyArray& Npz::Get(const std::string& name) const {
  const auto found = arrays_.find(name);
  if (found == arrays_.end()) throw Error(path_, name, "array is missing");
  return found->second;
}

const NpyArray& Npz::Get(const std::string& name, const std::vector<long>& shape) const {
  const NpyArray& array = Get(name);
  bool same = array.shape.size() == shape.size();
  for (size_t i = 0; same && i < shape.size(); ++i)
    same = shape[i] < 0 || size_t(shape[i]) == array.shape[i];
  if (!same)
    throw Error(
        path_, name, "has shape " + ShapeText(array.shape) + ", expected " + ShapeText(shape));
  return array;
}

void Npz::Add(const std::string& name,
              std::vector<size_t> shape,
              const std::vector<float>& values) {
  arrays_[name] = MakeArray(path_, name, std::move(shape), values, "<f4");
}

void Npz::Add(const std::string& name,
              std::vector<size_t> shape,
              const std::vector<int32_t>& values) {
  arrays_[name] = MakeArray(path_, name, std::move(shape), values, "<i4");
}

}  // namespace cosplat
