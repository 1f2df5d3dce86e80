// NumPy's .npy and .npz (zip of .npy), read and written. Little-endian, C or Fortran order on
// reading (returned in C order), float16/32/64, (u)int8/16/32/64 and bool; object arrays refused.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
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
  // What is added goes into this file: errors name it.
  explicit Npz(std::string path) : path_(std::move(path)) {}
  // Reads every array of numbers (text arrays are skipped) and every member that ends in .json.
  // Error names file and member.
  static Npz Read(const std::string& path);
  // Writes deflated, texts first, then arrays, each by name: as float16 or 32, int32 or uint8 or 16
  // where added or read as such, float32 otherwise. Atomic.
  void Write(const std::string& path) const;

  bool Has(const std::string& name) const { return arrays_.count(name) != 0; }
  // Error names the file and the missing array.
  const NpyArray& Get(const std::string& name) const;
  // The same, and checks the shape; -1 accepts any extent.
  const NpyArray& Get(const std::string& name, const std::vector<long>& shape) const;
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<float>& values);
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<int32_t>& values);
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<uint16_t>& values);
  void Add(const std::string& name, std::vector<size_t> shape, const std::vector<uint8_t>& values);
  void Add(const std::string& name, NpyArray array) { arrays_[name] = std::move(array); }
  // Stored as float16. Error naming the array when a number is not finite there.
  void AddHalf(const std::string& name,
               std::vector<size_t> shape,
               const std::vector<float>& values);

  // A member that is text, by its whole name, such as "header.json".
  void AddText(const std::string& member, const std::string& text) { texts_[member] = text; }
  bool HasText(const std::string& member) const { return texts_.count(member) != 0; }
  // Error names the file and the missing member.
  const std::string& Text(const std::string& member) const;

  const std::map<std::string, NpyArray>& arrays() const { return arrays_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::map<std::string, NpyArray> arrays_;
  std::map<std::string, std::string> texts_;
};

// One .npy array as bytes (NumPy format 1.0-3.0): what a member of a .npz holds.

// Parses an array; `file` and `member` name it in errors. Returns false (and leaves `array` alone)
// for arrays of text.
bool ParseNpy(const std::string& file,
              const std::string& member,
              const std::vector<char>& bytes,
              NpyArray& array);

// The bytes of a format 1.0 file in C order: of the array's dtype where that is float16 or 32,
// int32 or uint8 or 16, float32 otherwise.
std::string FormatNpy(const NpyArray& array);

}  // namespace cosplat
