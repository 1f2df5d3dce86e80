// Reading and writing of NumPy's .npy and .npz (zip of .npy). Reads little-endian float16/32/64,
// (u)int8/16/32/64 and bool in C or Fortran order (returned in C order); object arrays are
// rejected.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace cosplat {

class ZipReader;

// An array, converted to double on reading so that callers need not handle the stored type.
struct NpyArray {
  std::vector<size_t> shape;  // empty: a scalar
  std::vector<double> values;
  std::string dtype;  // as stored, e.g. "<f4"
  size_t size() const { return values.size(); }
};

class Npz {
 public:
  Npz() = default;
  // `path` names the file in errors about added arrays.
  explicit Npz(std::string path) : path_(std::move(path)) {}
  // Reads every numeric array (text arrays are skipped). Error names file and member.
  static Npz Read(const std::string& path);
  // The same of a file's bytes; `path` is for errors.
  static Npz Parse(const std::string& path, std::vector<char> bytes);
  // Writes compressed members, ordered by name: int32 if they were added or read as such, otherwise
  // float32. Atomic.
  void Write(const std::string& path) const;

  bool Has(const std::string& name) const { return arrays_.count(name) != 0; }
  // Error names the file and the missing array.
  const NpyArray& Get(const std::string& name) const;
  // Also checks the shape; -1 accepts any extent.
  const NpyArray& Get(const std::string& name, const std::vector<long>& shape) const;
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<float>& values);
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<int32_t>& values);
  void Add(const std::string& name, NpyArray array) { arrays_[name] = std::move(array); }

  const std::map<std::string, NpyArray>& arrays() const { return arrays_; }
  const std::string& path() const { return path_; }

 private:
  static Npz Read(const std::string& path, const ZipReader& archive);

  std::string path_;
  std::map<std::string, NpyArray> arrays_;
};

// The bytes of one .npy array (NumPy format 1.0-3.0), as in a member of an .npz.

// Parses an array; `file` and `member` name it in errors. Returns false (and leaves `array`
// unchanged) for text arrays.
bool ParseNpy(const std::string& file,
              const std::string& member,
              const std::vector<char>& bytes,
              NpyArray& array);

// The number that a half float's bits are.
double HalfToDouble(uint16_t half);

// Format 1.0 in C order, int32 if that is the array's dtype, otherwise float32.
std::string FormatNpy(const NpyArray& array);

}  // namespace cosplat
