// NumPy's .npy and .npz (zip of .npy), read and written. Little-endian, C or Fortran order on
// reading (returned in C order), float16/32/64, (u)int8/16/32/64 and bool; object arrays refused.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cosplat {

// One array, converted to double on reading so that callers need not care for the stored type.
struct NpyArray {
  std::vector<size_t> shape;  // empty: a scalar
  std::vector<double> values;
  std::string dtype;  // as stored, e.g. "<f4"
  size_t size() const { return values.size(); }
};

class Npz {
 public:
  Npz() = default;
  // Reads every array of numbers (text arrays are skipped). Error names file and member.
  static Npz Read(const std::string& path);
  // Writes deflated: as float32, or int32 where added or read as such. Atomic.
  void Write(const std::string& path) const;

  bool Has(const std::string& name) const { return arrays_.count(name) != 0; }
  // Error names the file and the missing array.
  const NpyArray& Get(const std::string& name) const;
  // The same, and checks the shape; -1 accepts any extent.
  const NpyArray& Get(const std::string& name, const std::vector<long>& shape) const;
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<float>& values);
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<int32_t>& values);
  const std::map<std::string, NpyArray>& arrays() const { return arrays_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::map<std::string, NpyArray> arrays_;
};

}  // namespace cosplat
