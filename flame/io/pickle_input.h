// Bounds-checked reading of a pickle's bytes and of the literals in its text opcodes. Private to
// flame/io/pickle.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cosplat {

class PickleInput {
 public:
  PickleInput(const std::string& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  // Each advances the position; throws Error if the file ends too early.
  uint64_t Unsigned(int count);  // little-endian, 1 to 8 bytes
  int64_t Signed(int count);     // two's complement
  double BigEndianDouble();
  std::string_view Bytes(uint64_t count);
  std::string_view Line();  // up to the newline, which is consumed; without a carriage return

  // Throws Error(file, "byte N", problem), where N is the position of the current opcode.
  [[noreturn]] void Fail(const std::string& problem) const;
  void BeginOpcode() { opcode_at_ = at_; }
  size_t size() const { return bytes_.size(); }

  // Literals of the text opcodes; all throw Error for anything else.
  int64_t ParseInteger(std::string_view text) const;  // decimal
  double ParseFloat(std::string_view text) const;
  std::string ParseQuoted(std::string_view text) const;      // a Python-2 string's repr
  std::string ParseRawUnicode(std::string_view text) const;  // \uXXXX, \UXXXXXXXX; to UTF-8
  // UTF-8 whose every code point is below 256 -> one byte each.
  std::string Latin1Bytes(std::string_view utf8) const;

 private:
  uint32_t ParseHex(std::string_view text, size_t at, size_t digits) const;

  std::string file_;
  std::string_view bytes_;
  size_t at_ = 0;
  size_t opcode_at_ = 0;
};

}  // namespace cosplat
