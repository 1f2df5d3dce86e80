// What a drive received and did not use, counted by name, for whoever wonders why a face stands
// still.
//
// VmcSource, JsonSource, PhoneSource -> UnusedInput -> LiveCounts -> NotesOf -> cosplat_health, the
// viewer. Names come from anybody: memory is bounded, and texts are printable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "flame/blendshape_names.h"

namespace cosplat {

// Printable ASCII on one line whatever is in `name`: of other characters their number, as in JSON;
// cut at 48 bytes.
std::string PrintableName(std::string_view name);

class NameCounts {
 public:
  static constexpr size_t kMaxNames = 32;  // further ones are counted together

  void Count(std::string_view name);
  bool empty() const { return counts_.empty(); }
  // How often one name came.
  uint64_t Of(std::string_view name) const;
  // The most frequent ones: "Joy (27), A (3), others (5)".
  std::string Text() const;

 private:
  std::map<std::string, uint64_t, std::less<>> counts_;  // at most kMaxNames, cut
  uint64_t others_ = 0;
};

struct UnusedInput {
  NameCounts messages;     // OSC addresses and whole packets that mean nothing here
  NameCounts blendshapes;  // scores that the map does not have
  NameCounts bones;        // other than neck, head and eyes
  NameCounts dropped;      // messages and scores that are not as they should be

  // "ignored messages: /Foo/Bar (27); ignored blendshapes: Joy (3); dropped: ...", or "".
  std::string Text() const;
};

// The place of a score in a map's names, or -1, which is counted. Those of the 52 that the map does
// not have are counted as one: they are many for the general map, whose description names what it
// moves.
int FindScore(const BlendshapeIndex& index, std::string_view name, UnusedInput& unused);

}  // namespace cosplat
