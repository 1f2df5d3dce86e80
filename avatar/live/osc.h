// Packets of Open Sound Control 1.0 (Wright 2002), read without trusting them.
//
// UdpInput -> ParseOsc -> VmcSource. Written here because liblo 0.31, the packaged library, reads
// behind the packet where a blob is announced at its end, and cannot listen on loopback alone.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cosplat {

constexpr size_t kMaxOscArguments = 32;
constexpr int kMaxOscBundles = 8;  // inside each other

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

// The packet's messages, those of bundles in order; they point into `packet`. Returns what is wrong
// with it, or "": then `messages` holds all of it.
std::string ParseOsc(std::string_view packet, std::vector<OscMessage>& messages);

}  // namespace cosplat
