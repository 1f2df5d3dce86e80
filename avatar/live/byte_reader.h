// Reads big-endian values from the front of a packet from an untrusted sender. Once something is
// missing, all further reads fail.
//
// ParseOsc, ParseLiveLink -> ByteReader.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace cosplat {

class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  bool empty() const { return bytes_.empty(); }
  // Whether nothing but padding is left.
  bool at_end() const { return bytes_.find_first_not_of('\0') == bytes_.npos; }

  std::string_view Bytes(size_t count) {
    ok_ = ok_ && count <= bytes_.size();
    if (!ok_) return {};
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }

  uint32_t Word() {
    uint32_t word = 0;
    for (const char c : Bytes(4)) word = word << 8 | uint8_t(c);
    return word;
  }

  float Float() { return std::bit_cast<float>(Word()); }

  uint64_t DoubleWord() {
    const uint64_t high = Word();
    return high << 32 | Word();
  }

  // Of OSC: a string that ends with a zero byte and is padded to a multiple of four.
  std::string_view Text() {
    const size_t size = bytes_.find('\0');
    ok_ = ok_ && size != bytes_.npos;
    return Bytes(ok_ ? size / 4 * 4 + 4 : 0).substr(0, ok_ ? size : 0);
  }

  // Of OSC: a byte count followed by that many bytes, padded likewise.
  std::string_view Blob() {
    const uint64_t size = Word();
    return Bytes((size + 3) / 4 * 4).substr(0, ok_ ? size : 0);
  }

 private:
  std::string_view bytes_;
  bool ok_ = true;
};

}  // namespace cosplat
