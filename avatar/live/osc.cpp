#include "avatar/live/osc.h"

#include <bit>
#include <cmath>
#include <cstdint>

namespace cosplat {
namespace {

constexpr std::string_view kBundle("#bundle\0", 8);

// Reads values from the front of a byte string. Once something is missing, all further reads fail.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

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

  uint64_t DoubleWord() {
    const uint64_t high = Word();
    return high << 32 | Word();
  }

  // A string that ends with a zero byte and is padded to a multiple of four.
  std::string_view Text() {
    const size_t size = bytes_.find('\0');
    ok_ = ok_ && size != bytes_.npos;
    return Bytes(ok_ ? size / 4 * 4 + 4 : 0).substr(0, ok_ ? size : 0);
  }

  // A byte count followed by that many bytes, padded likewise.
  std::string_view Blob() {
    const uint64_t size = Word();
    return Bytes((size + 3) / 4 * 4).substr(0, ok_ ? size : 0);
  }

 private:
  std::string_view bytes_;
  bool ok_ = true;
};

// Reads the value for `argument.type`; returns false for types that OSC does not have.
bool ReadArgument(Reader& reader, OscArgument& argument) {
  switch (argument.type) {
    case 'i':
      argument.number = int32_t(reader.Word());
      return true;
    case 'f':
      argument.number = std::bit_cast<float>(reader.Word());
      return true;
    case 'h':
      argument.number = double(int64_t(reader.DoubleWord()));
      return true;
    case 'd':
      argument.number = std::bit_cast<double>(reader.DoubleWord());
      return true;
    case 's':
    case 'S':
      argument.text = reader.Text();
      return true;
    case 'b':
      argument.text = reader.Blob();
      argument.text = argument.text.substr(0, argument.text.find('\0'));
      return true;
    case 't':  // a time tag
      reader.DoubleWord();
      return true;
    case 'c':  // a character, a colour, a MIDI message
    case 'r':
    case 'm':
      reader.Word();
      return true;
    case 'T':
      argument.number = 1;
      return true;
    case 'F':
    case 'N':
    case 'I':
    case '[':
    case ']':
      return true;
    default:
      return false;
  }
}

// Returns what is wrong with the message, or "".
std::string_view ParseMessage(std::string_view bytes, OscMessage& message) {
  Reader reader(bytes);
  const std::string_view address = reader.Text();
  if (!reader.ok() || !address.starts_with('/')) return "has no OSC address";
  message.address = address;
  if (reader.empty()) return "";  // old senders omit the type tags when there are no arguments
  std::string_view types = reader.Text();
  if (!types.starts_with(',')) return "has no OSC type tags";
  types.remove_prefix(1);
  static_assert(kMaxOscArguments == 32);
  if (types.size() > kMaxOscArguments) return "has more than 32 arguments";
  for (const char type : types) {
    OscArgument& argument = message.arguments.emplace_back();
    argument.type = type;
    if (!ReadArgument(reader, argument)) return "has an argument of an unknown OSC type";
  }
  if (!reader.ok()) return "ends within its arguments";
  return reader.at_end() ? "" : "is longer than its OSC type tags imply";
}

void ParseElement(std::string_view bytes, int bundles, std::vector<OscMessage>& messages) {
  const auto fail = [&](std::string_view problem) { messages.emplace_back().problem = problem; };
  if (!IsOscBundle(bytes)) {
    OscMessage& message = messages.emplace_back();
    message.problem = ParseMessage(bytes, message);
    return;
  }
  if (bundles == kMaxOscBundles) return fail("has OSC bundles nested too deeply");
  Reader reader(bytes);
  reader.Text();
  reader.DoubleWord();  // the time tag, ignored: bundles take effect at once
  while (reader.ok() && !reader.at_end()) {
    const std::string_view element = reader.Bytes(reader.Word());
    if (reader.ok() && !element.empty()) ParseElement(element, bundles + 1, messages);
  }
  if (!reader.ok()) fail("ends within an OSC bundle");
}

}  // namespace

bool OscArgument::IsNumber() const {
  return std::string_view("ihfdTF").find(type) != std::string_view::npos && std::isfinite(number);
}

bool IsOscBundle(std::string_view packet) { return packet.starts_with(kBundle); }

void ParseOsc(std::string_view packet, std::vector<OscMessage>& messages) {
  messages.clear();
  ParseElement(packet, 0, messages);
}

}  // namespace cosplat
