// Files that hold the state of a computation exactly: checkpoints of training.
//
// One description serves both directions. `Serialize(archive, state)` visits the fields of a state
// in a fixed order, and the archive either writes each field or sets it:
//
//   WriteStateFile(path, header, [&](StateArchive& a) { Serialize(a, state); });
//   StateFile(path).Read([&](StateArchive& a) { Serialize(a, state); });
//
// Layout, little-endian: kStateMagic; uint32 kStateFormat; the header, which says what state it is;
// the fields; the CRC-32 (ISO 3309) of everything before. Header and fields alike are a uint32 with
// the length of the name, the name, a uint64 with the number of bytes, the bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace cosplat {

// To be raised with every change of what is described, anywhere.
constexpr uint32_t kStateFormat = 8;

class StateArchive {
 public:
  virtual ~StateArchive() = default;
  StateArchive() = default;
  StateArchive(const StateArchive&) = delete;
  StateArchive& operator=(const StateArchive&) = delete;

  virtual bool reads() const = 0;

  // A number, an enumeration, or a struct of numbers without padding.
  template <class T>
  void Value(const std::string& name, T& value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    Bytes(name, &value, sizeof value);
  }
  // A std::vector or a Buffer in host memory, of exactly `count` elements: reading throws Error if
  // it was written with another number.
  template <class Container>
  void Array(const std::string& name, Container& elements, size_t count) {
    using T = typename Container::value_type;
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    if (reads()) {
      CheckSize(name, count, sizeof(T));
      elements.resize(count);
    } else if (elements.size() != count) {
      Fail(name, Counted(elements.size(), count));
    }
    Bytes(name, elements.data(), count * sizeof(T));
  }
  // An array of any number of elements, up to `max`.
  template <class Container>
  void ArrayUpTo(const std::string& name, Container& elements, size_t max) {
    uint64_t count = elements.size();
    Value(name + ".count", count);
    if (count > max) Fail(name, Counted(count, max));
    Array(name, elements, size_t(count));
  }
  // Throws Error that names the file and the field.
  [[noreturn]] virtual void Fail(const std::string& name, const std::string& problem) const = 0;
  void Require(bool holds, const std::string& name, const std::string& problem) const {
    if (!holds) Fail(name, problem);
  }

 private:
  virtual void Bytes(const std::string& name, void* bytes, size_t size) = 0;
  // When reading: that the next field has this name and this many elements.
  virtual void CheckSize(const std::string& name, size_t count, size_t element) const = 0;
  static std::string Counted(uint64_t found, uint64_t expected) {
    return "has " + std::to_string(found) + " elements, expected " + std::to_string(expected);
  }
};

using StateDescription = std::function<void(StateArchive&)>;

// Writes the file as WriteFileDurably (splat/base/files.h) does. Throws Error as that does.
void WriteStateFile(const std::string& path,
                    const std::string& header,
                    const StateDescription& describe);

// Visits all fields and writes nothing: for processes that have a part of a state that another one
// writes.
void DiscardState(const StateDescription& describe);

class StateFile {
 public:
  // Reads the file. Throws Error if it is not a state file, has another format, is incomplete, or
  // its checksum does not match.
  explicit StateFile(const std::string& path);
  const std::string& path() const { return path_; }
  const std::string& header() const { return header_; }
  // Throws Error, naming the field, if the description does not match what was written; the state
  // is then partly set.
  void Read(const StateDescription& describe) const;

 private:
  std::string path_, header_;
  std::vector<char> bytes_;
  size_t fields_ = 0, end_ = 0;  // first byte of the fields, first byte of the checksum
};

}  // namespace cosplat
