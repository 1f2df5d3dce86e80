#include "avatar/live/osc.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "avatar/live/byte_reader.h"

namespace cosplat {
namespace {

constexpr std::string_view kBundle("#bundle\0", 8);

// Reads the value for `argument.type`; returns false for types that OSC does not have.
bool ReadArgument(ByteReader& reader, OscArgument& argument) {
  switch (argument.type) {
    case 'i':
      argument.number = int32_t(reader.Word());
      return true;
    case 'f':
      argument.number = reader.Float();
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
  ByteReader reader(bytes);
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
  ByteReader reader(bytes);
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
