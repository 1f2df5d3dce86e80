// A parser of Open Sound Control 1.0 packets (Wright 2002) from untrusted senders.
//
// UdpInput -> ParseOsc -> VmcSource. Written here because liblo 0.31, the packaged library, reads
// beyond the end of a packet when a blob is announced there, and cannot listen on loopback only.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cosplat {

constexpr size_t kMaxOscArguments = 32;
constexpr int kMaxOscBundles = 8;  // nested

struct OscArgument {
  char type = 0;
  double number = 0;      // of types i, h, f, d, T and F
  std::string_view text;  // of types s and S
  bool IsNumber() const;  // finite
  bool IsText() const { return type == 's' || type == 'S'; }
};

struct OscMessage {
  std::string_view address;
  std::vector<OscArgument> arguments;
};

// Parses the packet's messages, those of bundles in order; they point into `packet`. Returns a
// description of what is wrong with the packet, or "" if `messages` is complete.
std::string ParseOsc(std::string_view packet, std::vector<OscMessage>& messages);

}  // namespace cosplat
