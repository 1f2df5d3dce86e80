#include "splat/base/npz.h"

#include <cmath>
#include <utility>

#include "splat/base/error.h"
#include "splat/base/zip_reader.h"

namespace cosplat {
namespace {

std::string ShapeText(const std::vector<size_t>& shape) {
  std::string text = "[";
  for (size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
  return text + "]";
}

std::string ShapeText(const std::vector<long>& shape) {
  std::string text = "[";
  for (size_t i = 0; i < shape.size(); ++i)
    text += (i ? ", " : "") + (shape[i] < 0 ? std::string("*") : std::to_string(shape[i]));
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

Npz Npz::Read(const std::string& path) {
  const ZipReader archive(path, ".npz");
  Npz npz;
  npz.path_ = path;
  for (size_t i = 0; i < archive.size(); ++i) {
    const std::string name = archive.Name(i);
    if (!name.ends_with(".npy") && !name.ends_with(".json")) continue;
    const std::vector<char> bytes = archive.Read(i);
    NpyArray array;
    if (name.ends_with(".json"))
      npz.texts_[name].assign(bytes.begin(), bytes.end());
    else if (ParseNpy(path, name, bytes, array))
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

const std::string& Npz::Text(const std::string& member) const {
  const auto found = texts_.find(member);
  if (found == texts_.end()) throw Error(path_, member, "is missing");
  return found->second;
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

void Npz::Add(const std::string& name,
              std::vector<size_t> shape,
              const std::vector<uint16_t>& values) {
  arrays_[name] = MakeArray(path_, name, std::move(shape), values, "<u2");
}

void Npz::Add(const std::string& name,
              std::vector<size_t> shape,
              const std::vector<uint8_t>& values) {
  arrays_[name] = MakeArray(path_, name, std::move(shape), values, "|u1");
}

void Npz::AddHalf(const std::string& name,
                  std::vector<size_t> shape,
                  const std::vector<float>& values) {
  constexpr float kBeyond = 65520;  // is rounded to infinity
  for (size_t i = 0; i < values.size(); ++i)
    if (!(std::abs(values[i]) < kBeyond))
      throw Error(path_,
                  name,
                  "number " + std::to_string(i) + " is " + std::to_string(values[i]) +
                      ", float16 is limited to magnitudes below 65520");
  arrays_[name] = MakeArray(path_, name, std::move(shape), values, "<f2");
}

}  // namespace cosplat
