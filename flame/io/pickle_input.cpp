#include "flame/io/pickle_input.h"

#include <algorithm>
#include <bit>
#include <charconv>

#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

void AppendUtf8(std::string& out, uint32_t code) {
  if (code < 0x80) {
    out += char(code);
  } else if (code < 0x800) {
    out += char(0xC0 | code >> 6);
    out += char(0x80 | (code & 63));
  } else if (code < 0x10000) {
    out += char(0xE0 | code >> 12);
    out += char(0x80 | (code >> 6 & 63));
    out += char(0x80 | (code & 63));
  } else {
    out += char(0xF0 | (code >> 18 & 7));
    out += char(0x80 | (code >> 12 & 63));
    out += char(0x80 | (code >> 6 & 63));
    out += char(0x80 | (code & 63));
  }
}

}  // namespace

void PickleInput::Fail(const std::string& problem) const {
  throw Error(file_, "byte " + std::to_string(opcode_at_), problem);
}

std::string_view PickleInput::Bytes(uint64_t count) {
  if (count > bytes_.size() - at_)
    Fail("the file ends where " + std::to_string(count) + " bytes should follow");
  const std::string_view bytes = bytes_.substr(at_, count);
  at_ += count;
  return bytes;
}

uint64_t PickleInput::Unsigned(int count) {
  const std::string_view bytes = Bytes(count);
  uint64_t value = 0;
  for (int i = count; i-- > 0;) value = value << 8 | uint8_t(bytes[i]);
  return value;
}

int64_t PickleInput::Signed(int count) {
  if (count == 0) return 0;
  const uint64_t value = Unsigned(count);
  const int unused = 64 - 8 * count;
  return int64_t(value << unused) >> unused;
}

double PickleInput::BigEndianDouble() {
  uint64_t bits = 0;
  for (char c : Bytes(8)) bits = bits << 8 | uint8_t(c);
  return std::bit_cast<double>(bits);
}

std::string_view PickleInput::Line() {
  const size_t end = bytes_.find('\n', at_);
  if (end == std::string_view::npos) Fail("the file ends inside a line");
  std::string_view line = bytes_.substr(at_, end - at_);
  at_ = end + 1;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

int64_t PickleInput::ParseInteger(std::string_view text) const {
  const std::optional<int64_t> value = NumberOf<int64_t>(text);
  if (!value) Fail("expected an integer of at most 64 bits");
  return *value;
}

double PickleInput::ParseFloat(std::string_view text) const {
  const std::optional<double> value = NumberOf<double>(text);
  if (!value) Fail("expected a number");
  return *value;
}

uint32_t PickleInput::ParseHex(std::string_view text, size_t at, size_t digits) const {
  uint32_t value = 0;
  const std::string_view hex = text.substr(std::min(at, text.size()), digits);
  const auto [end, code] = std::from_chars(hex.data(), hex.data() + hex.size(), value, 16);
  if (hex.size() != digits || code != std::errc() || end != hex.data() + hex.size())
    Fail("a string holds a broken \\ escape");
  return value;
}

std::string PickleInput::ParseQuoted(std::string_view text) const {
  if (text.size() < 2 || (text[0] != '\'' && text[0] != '"') || text.back() != text[0])
    Fail("expected a quoted string");
  text = text.substr(1, text.size() - 2);
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\') {
      out += text[i];
      continue;
    }
    const char c = ++i < text.size() ? text[i] : '\0';
    if (c == '\\' || c == '\'' || c == '"') {
      out += c;
    } else if (c == 'n' || c == 'r' || c == 't') {
      out += c == 'n' ? '\n' : c == 'r' ? '\r' : '\t';
    } else if (c == 'x') {
      out += char(ParseHex(text, i + 1, 2));
      i += 2;
    } else {
      Fail("a string holds a broken \\ escape");
    }
  }
  return out;
}

std::string PickleInput::ParseRawUnicode(std::string_view text) const {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i] == '\\' && i + 1 < text.size() ? text[i + 1] : '\0';
    if (c != 'u' && c != 'U') {
      AppendUtf8(out, uint8_t(text[i]));
      continue;
    }
    const size_t digits = c == 'u' ? 4 : 8;
    const uint32_t code = ParseHex(text, i + 2, digits);
    if (code > 0x10FFFF) Fail("a string holds a broken \\ escape");
    AppendUtf8(out, code);
    i += 1 + digits;
  }
  return out;
}

std::string PickleInput::Latin1Bytes(std::string_view utf8) const {
  std::string out;
  out.reserve(utf8.size());
  for (size_t i = 0; i < utf8.size(); ++i) {
    const uint8_t c = utf8[i];
    if (c < 0x80) {
      out += char(c);
      continue;
    }
    // Code points 0x80 to 0xFF are C2 or C3 and one more byte.
    const uint8_t next = i + 1 < utf8.size() ? uint8_t(utf8[i + 1]) : 0;
    if ((c != 0xC2 && c != 0xC3) || next >> 6 != 2) Fail("a string is not latin1");
    out += char((c & 3) << 6 | (next & 63));
    ++i;
  }
  return out;
}

}  // namespace cosplat
