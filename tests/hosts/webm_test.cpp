// The line of docs/plugin.md, by gst-launch-1.0 itself: what the video shows is what the library
// draws.
#include <cmath>
#include <cstdlib>

#include "tests/hosts/gstreamer_fixture.h"

namespace cosplat::test {
namespace {

// Root mean square of the difference of the colours; alpha left out.
double Difference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i)
    if (i % 4 != 3) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
  return std::sqrt(sum / (0.75 * double(a.size())));
}

// The face that is driven so, at 25 frames per second.
std::vector<std::vector<uint8_t>> Expected(const std::string& drive, size_t count) {
  const OpenAvatar avatar;
  EXPECT_EQ(cosplat_set_drive(avatar, drive.c_str()), COSPLAT_OK);
  std::vector<std::vector<uint8_t>> pictures;
  for (size_t n = 0; n < count; ++n) {
    EXPECT_EQ(cosplat_advance(avatar, int64_t(n) * 40'000'000), COSPLAT_OK);
    pictures.push_back(Draw(avatar, {}));
  }
  return pictures;
}

TEST(GstLaunch, WritesAVideoOfTheLibrarysPictures) {
  gst_init(nullptr, nullptr);
  for (const char* name : {"vp8enc", "vp8dec", "webmmux", "matroskademux"}) {
    GstElementFactory* factory = gst_element_factory_find(name);
    if (!factory) GTEST_SKIP() << "there is no " << name << ": gstreamer1.0-plugins-good";
    gst_object_unref(factory);
  }
  const std::string out = PluginFiles::Get().folder / "out.webm";
  const std::string drive = WriteRecording(10, 25);
  const std::string line = "gst-launch-1.0 -q cosplatsrc " + AvatarProperties() +
                           " drive=" + drive +
                           " fps=25 ! videoconvert ! vp8enc target-bitrate=4000000 ! webmmux" +
                           " ! filesink location=" + out;
  ASSERT_EQ(std::system(line.c_str()), 0) << line;
  Pipeline decoder("filesrc location=" + out +
                   " ! matroskademux ! vp8dec ! videoconvert ! video/x-raw,format=RGBA");
  const std::vector<PulledFrame> frames = decoder.PlayAll();
  ASSERT_EQ(frames.size(), 10u);
  const std::vector<std::vector<uint8_t>> expected = Expected(drive, frames.size());
  double max = 0;
  for (size_t n = 0; n < frames.size(); ++n) {
    ASSERT_EQ(frames[n].bytes.size(), expected[n].size());
    const double own = Difference(frames[n].bytes, expected[n]);
    max = std::max(max, own);
    EXPECT_LT(own, Difference(frames[n].bytes, expected[9 - n])) << n;
  }
  RecordProperty("difference", std::to_string(max));
  // Measured: 3.9, most of it at edges, since VP8 has colours at half the resolution.
  EXPECT_LT(max, 5);
}

}  // namespace
}  // namespace cosplat::test
