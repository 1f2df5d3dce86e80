// A parser of Open Sound Control 1.0 packets (Wright 2002) from untrusted senders.
//
// UdpInput -> ParseOsc -> VmcSource. Written here because liblo 0.31, the packaged library, reads
// beyond the end of a packet when a blob is announced there, and cannot listen on loopback only.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace cosplat {

constexpr size_t kMaxOscArguments = 32;
constexpr int kMaxOscBundles = 8;  // nested

struct OscArgument {
  char type = 0;
  double number = 0;      // of types i, h, f, d, T and F
  std::string_view text;  // of types s, S and b
  bool IsNumber() const;  // finite
  // A blob counts as text up to its first zero: some libraries send strings so.
  bool IsText() const { return type == 's' || type == 'S' || type == 'b'; }
};

struct OscMessage {
  std::string_view address;  // empty if the bytes are no message
  std::vector<OscArgument> arguments;
  std::string_view problem;  // what is wrong with it, a constant; "" if it is complete
};

// Parses the packet's messages, those of bundles in order; they point into `packet`. What is wrong
// with one costs only that one, since bundles say how long their elements are; what is wrong with a
// bundle is a message of its own, after those before it. Zeros at the end of a message or of a
// bundle are padding.
void ParseOsc(std::string_view packet, std::vector<OscMessage>& messages);
// Whether it is a bundle: several messages that are meant together.
bool IsOscBundle(std::string_view packet);

}  // namespace cosplat
