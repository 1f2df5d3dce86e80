// Video of a high dynamic range (phones', above all) as a screen of the usual range shows it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cosplat {

// ITU-R BT.2100-2: hybrid log-gamma (its table 5), perceptual quantisation (its table 4).
enum class HdrTransfer { kHlg, kPq };

class HdrToSdr {
 public:
  // wide_primaries: those of BT.2020, else of BT.709.
  HdrToSdr(HdrTransfer transfer, bool wide_primaries);
  // from: pixels of `channels` numbers of 16 bits, as the video encodes them, full range; R, G and
  // B first. to: sRGB; a fourth channel (alpha) keeps its value.
  void Convert(const uint16_t* from, size_t pixels, int channels, uint8_t* to) const;

 private:
  HdrTransfer transfer_;
  bool wide_primaries_;
  std::vector<float> light_;  // of a code value: HLG's of the scene, 0 to 1; PQ's shown, in white's
  // By square roots, so that what is dark has entries enough:
  std::vector<float> gain_;    // HLG's screen's, of the scene's luminance
  std::vector<float> shown_;   // what is left of the brightest channel
  std::vector<uint8_t> srgb_;  // of shown light
};

}  // namespace cosplat
