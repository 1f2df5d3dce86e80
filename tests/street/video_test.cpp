// Videos as phones, browsers and cameras write them are read as a player shows them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "splat/base/error.h"
#include "splat/media/hdr.h"
#include "tests/street/film.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

// The colours of FourColors where they are shown, as letters from the top left: "RBGW" is upright.
std::string ColorsOf(const Image8& image) {
  std::string colors;
  for (const int y : {1, 3}) {
    for (const int x : {1, 3}) {
      const size_t pixel = size_t(y * image.height / 4) * image.width + x * image.width / 4;
      const uint8_t* rgb = &image.data[image.channels * pixel];
      const bool r = rgb[0] > 128, g = rgb[1] > 128, b = rgb[2] > 128;
      colors += r && g && b ? 'W' : r ? 'R' : g ? 'G' : b ? 'B' : '?';
    }
  }
  return colors;
}

double PsnrOf(const Image8& a, const Image8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.data.size(); ++i)
    sum += (a.data[i] - b.data[i]) * (a.data[i] - b.data[i]);
  return 10 * std::log10(255.0 * 255.0 * double(a.data.size()) / sum);
}

TEST(Video, IsTurnedAsItsDisplayMatrixSays) {
  const TemporaryFolder folder;
  struct Case {
    int a, b, c, d;
    const char* colors;
    bool exchanged;
  };
  // What is shown where, worked out by hand: x = a p + c q, y = b p + d q.
  const Case cases[] = {{1, 0, 0, 1, "RBGW", false},
                        {0, 1, -1, 0, "GRWB", true},  // a quarter turn to the right
                        {0, -1, 1, 0, "BWRG", true},  // to the left
                        {-1, 0, 0, -1, "WGBR", false},
                        {-1, 0, 0, 1, "BRWG", false},  // as in a mirror
                        {1, 0, 0, -1, "GWRB", false},
                        {0, 1, 1, 0, "RGBW", true},
                        {0, -1, -1, 0, "WBGR", true}};
  for (const Case& c : cases) {
    const std::string path = folder / "turned.mp4";
    WriteFilm({.path = path, .frames = Frames(3)});
    SetDisplayMatrix(path, c.a, c.b, c.c, c.d);
    VideoReader video(path);
    const Image8 image = video.ReadFrame(1);
    EXPECT_EQ(image.width, c.exchanged ? 48 : 64) << c.colors;
    EXPECT_EQ(image.height, c.exchanged ? 64 : 48) << c.colors;
    EXPECT_EQ(ColorsOf(image), c.colors);
  }
}

TEST(Video, HasSquarePixels) {
  const TemporaryFolder folder;
  const auto size = [&](AVRational pixel) {
    WriteFilm({.path = folder / "wide.mp4", .pixel = pixel, .frames = Frames(3)});
    const Image8 image = VideoReader(folder / "wide.mp4").ReadFrame(0);
    EXPECT_EQ(ColorsOf(image), "RBGW");
    return SizeText(image.width, image.height);
  };
  EXPECT_EQ(size({4, 3}), "85x48");
  EXPECT_EQ(size({3, 4}), "64x64");
  EXPECT_EQ(size({0, 1}), "64x48");
}

TEST(Video, KeepsItsFirstSize) {
  const TemporaryFolder folder;
  Film film{.path = folder / "call.webm", .encoder = "libvpx", .frames = Frames(8)};
  for (size_t i = 4; i < 8; ++i) film.frames[i].width = 96, film.frames[i].height = 72;
  WriteFilm(film);
  VideoReader video(film.path);
  ASSERT_EQ(video.frame_count(), 8);
  for (int i = 0; i < 8; ++i) {
    const Image8 image = video.ReadFrame(i);
    EXPECT_EQ(SizeText(image.width, image.height), "64x48");
    EXPECT_EQ(ColorsOf(image), "RBGW") << i;
  }
  ASSERT_EQ(video.notes().size(), 1u);
  EXPECT_NE(video.notes()[0].find("4 of 8 frames have another size (96x72)"), std::string::npos);
}

TEST(Video, KeepsTheShapeOfAllFrames) {
  const TemporaryFolder folder;
  Film film{.path = folder / "turned.webm", .encoder = "libvpx", .frames = Frames(6)};
  for (size_t i = 3; i < 6; ++i) std::swap(film.frames[i].width, film.frames[i].height);
  WriteFilm(film);
  VideoReader video(film.path);
  for (int i = 0; i < 6; ++i) {
    const Image8 image = video.ReadFrame(i);
    ASSERT_EQ(SizeText(image.width, image.height), "64x48") << i;
    const uint8_t* left = &image.at(4, 24, 0);
    if (i < 3) {
      EXPECT_EQ(ColorsOf(image), "RBGW") << i;
    } else {  // 36x48 px in the middle
      EXPECT_EQ(int(left[0]) + left[1] + left[2], 0) << i;
      EXPECT_GT(image.at(24, 10, 0), 128) << i;
      EXPECT_GT(image.at(40, 40, 2), 128) << i;
    }
  }
  ASSERT_EQ(video.notes().size(), 1u);
  EXPECT_NE(video.notes()[0].find("3 of 6 frames have another size (48x64)"), std::string::npos);
}

TEST(Video, HasTheRateOfItsTimeStamps) {
  const TemporaryFolder folder;
  Film film{.path = folder / "recorder.webm", .encoder = "libvpx", .states_rate = false};
  int64_t time = 0;
  for (int i = 0; i < 46; ++i, time += i % 2 == 0 ? 30 : 50)
    film.frames.push_back({64, 48, time, 255});
  WriteFilm(film);
  EXPECT_NEAR(VideoReader(film.path).frames_per_second(), 25, 0.3);
  WriteFilm({.path = folder / "steady.mp4", .frames = Frames(20)});
  EXPECT_EQ(VideoReader(folder / "steady.mp4").frames_per_second(), 25);
}

TEST(Video, HasItsAlpha) {
  const TemporaryFolder folder;
  for (const char* encoder : {"libvpx", "libvpx-vp9"}) {
    Film film{
        .path = folder / "alpha.webm", .encoder = encoder, .alpha = true, .frames = Frames(4)};
    for (FilmFrame& frame : film.frames) frame.alpha = 64;
    WriteFilm(film);
    VideoReader video(film.path);
    EXPECT_TRUE(video.has_alpha()) << encoder;
    const Image8 image = video.ReadFrame(2);
    ASSERT_EQ(image.channels, 4) << encoder;
    EXPECT_NEAR(image.data[3], 64, 3) << encoder;
    EXPECT_EQ(ColorsOf(image), "RBGW") << encoder;
  }
}

TEST(Video, MayHaveAColonInItsName) {
  const TemporaryFolder folder;
  const std::string path = folder / "2024-03-01T10:20:30.mp4";
  VideoWriter writer(path, 64, 48, 25);
  writer.Write(FourColors(64, 48));
  writer.Finish();
  VideoReader video(path);
  EXPECT_EQ(video.frame_count(), 1);
  EXPECT_EQ(ColorsOf(video.ReadFrame(0)), "RBGW");
}

TEST(Video, ThatEndsTooEarlyKeepsWhatItHasAndSaysSo) {
  const TemporaryFolder folder;
  for (const auto& [name, encoder] :
       {std::pair{"cut.avi", "mpeg4"}, {"cut.mkv", "mpeg4"}, {"cut.webm", "libvpx"}}) {
    const std::string path = folder / name;
    WriteFilm({.path = path, .encoder = encoder, .frames = Frames(50, 320, 240)});
    EXPECT_TRUE(VideoReader(path).notes().empty()) << name;
    std::filesystem::resize_file(path, std::filesystem::file_size(path) * 4 / 10);
    VideoReader video(path);
    EXPECT_GT(video.frame_count(), 5) << name;
    EXPECT_LT(video.frame_count(), 45) << name;
    for (int i = 0; i < video.frame_count(); ++i)
      EXPECT_EQ(ColorsOf(video.ReadFrame(i)), "RBGW") << name << " " << i;
    // FFmpeg takes an AVI's length from what is there of it.
    EXPECT_EQ(video.notes().empty(), std::string(name) == "cut.avi") << name;
  }
}

// The shown light of a colour in HDR, in white's: ITU-R BT.2100's HLG, from what a screen of
// 1,000 cd/m2 shows back to what is encoded.
std::array<uint16_t, 3> HlgOf(std::array<double, 3> rgb) {
  for (double& c : rgb) c *= 203 / 1000.0;
  const double shown = 0.2627 * rgb[0] + 0.6780 * rgb[1] + 0.0593 * rgb[2];
  std::array<uint16_t, 3> code;
  for (int c = 0; c < 3; ++c) {
    const double scene = shown == 0 ? 0 : rgb[c] * std::pow(shown, 1 / 1.2 - 1);
    const double e = scene <= 1 / 12.0
                         ? std::sqrt(3 * scene)
                         : 0.17883277 * std::log(12 * scene - 0.28466892) + 0.55991073;
    code[c] = uint16_t(std::lround(65535 * e));
  }
  return code;
}
std::array<uint16_t, 3> PqOf(std::array<double, 3> rgb) {
  std::array<uint16_t, 3> code;
  for (int c = 0; c < 3; ++c) {
    const double y = std::pow(rgb[c] * 203 / 10000, 0.1593017578125);
    const double e = std::pow((0.8359375 + 18.8515625 * y) / (1 + 18.6875 * y), 78.84375);
    code[c] = uint16_t(std::lround(65535 * e));
  }
  return code;
}
int SrgbOf(double light) {
  return int(std::lround(255 * (1.055 * std::pow(light, 1 / 2.4) - 0.055)));
}

TEST(Video, InHdrHasTheColorsOfAScreen) {
  for (const HdrTransfer transfer : {HdrTransfer::kHlg, HdrTransfer::kPq}) {
    const HdrToSdr hdr(transfer, true);
    const auto shown = [&](std::array<double, 3> light) {
      const std::array<uint16_t, 3> code =
          transfer == HdrTransfer::kHlg ? HlgOf(light) : PqOf(light);
      std::array<uint8_t, 3> rgb;
      hdr.Convert(code.data(), 1, 3, rgb.data());
      return std::array<int, 3>{rgb[0], rgb[1], rgb[2]};
    };
    // Up to 86 cd/m2, where skin is, as an SDR screen shows the same light; grey stays grey.
    for (const double light : {0.01, 0.05, 0.18, 0.3, 0.42}) {
      const std::array<int, 3> rgb = shown({light, light, light});
      for (const int c : rgb) EXPECT_NEAR(c, SrgbOf(light), 1) << light;
    }
    EXPECT_EQ(shown({0, 0, 0}), (std::array{0, 0, 0}));
    // BT.709's red, green and blue in BT.2020's primaries (BT.2087).
    const double red[] = {0.6274, 0.0691, 0.0164}, green[] = {0.3293, 0.9195, 0.0880},
                 blue[] = {0.0433, 0.0114, 0.8956};
    for (int c = 0; c < 3; ++c) {
      const double* from = c == 0 ? red : c == 1 ? green : blue;
      const std::array<int, 3> rgb = shown({0.4 * from[0], 0.4 * from[1], 0.4 * from[2]});
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(rgb[k], k == c ? SrgbOf(0.4) : 0, 3) << c << k;
    }
    // What is brighter than white keeps its order, below 255 until a screen's end.
    int last = 0;
    for (const double light : {0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.9}) {
      const int now = shown({light, light, light})[0];
      EXPECT_GT(now, last) << light;
      last = now;
    }
    EXPECT_NEAR(shown({1, 1, 1})[0], 230, 2);
    EXPECT_EQ(last, 255);
  }
}

TEST(Video, InHdrIsReadAsOne) {
  const TemporaryFolder folder;
  for (const auto transfer : {AVCOL_TRC_ARIB_STD_B67, AVCOL_TRC_SMPTE2084}) {
    const double light = 0.2;
    const std::array<uint16_t, 3> code = transfer == AVCOL_TRC_SMPTE2084
                                             ? PqOf({light, light, light})
                                             : HlgOf({light, light, light});
    // Grey in limited range.
    const auto fill = [&](AVFrame& frame) {
      for (int plane = 0; plane < 3; ++plane) {
        const uint16_t value =
            plane == 0 ? uint16_t(std::lround(64 + 876 * code[0] / 65535.0)) : uint16_t(512);
        const int lines = plane == 0 ? frame.height : frame.height / 2;
        for (int y = 0; y < lines; ++y)
          std::fill_n(reinterpret_cast<uint16_t*>(frame.data[plane] + y * frame.linesize[plane]),
                      plane == 0 ? frame.width : frame.width / 2,
                      value);
      }
    };
    WriteFilm({.path = folder / "phone.mkv",
               .encoder = "ffv1",
               .transfer = transfer,
               .format = AV_PIX_FMT_YUV420P10,
               .fill = fill,
               .frames = Frames(2)});
    VideoReader video(folder / "phone.mkv");
    ASSERT_EQ(video.notes().size(), 1u);
    EXPECT_NE(video.notes()[0].find("is HDR video"), std::string::npos);
    const Image8 image = video.ReadFrame(1);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(30, 20, c), SrgbOf(light), 1);
  }
}

TEST(Video, OfDolbyVisionAloneIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "film.mp4";
  WriteFilm({.path = path, .dolby_vision_profile = 5, .frames = Frames(2)});
  ExpectError([&] { VideoReader{path}; }, {path, "is Dolby Vision of profile 5"});
}

TEST(Video, ThatIsInterlacedHasOneTimeInAFrame) {
  const TemporaryFolder folder;
  // A bar that has moved by 12 px between the fields; then one at rest, with a sensor's noise.
  for (const int moved : {12, 0}) {
    std::minstd_rand random(1);
    const auto fill = [&](AVFrame& frame) {
      for (int plane = 0; plane < 3; ++plane)
        std::memset(frame.data[plane],
                    128,
                    size_t(frame.linesize[plane]) * (plane == 0 ? frame.height : frame.height / 2));
      for (int y = 0; y < frame.height; ++y)
        std::memset(frame.data[0] + y * frame.linesize[0] + 20 + (y % 2 == 1 ? moved : 0), 235, 10);
      for (int y = 0; moved == 0 && y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          uint8_t& luma = frame.data[0][y * frame.linesize[0] + x];
          luma = uint8_t(luma + int(random() % 37) - 18);
        }
      }
    };
    WriteFilm({.path = folder / "camcorder.mkv",
               .encoder = "ffv1",
               .interlaced = true,
               .fill = fill,
               .frames = Frames(3)});
    VideoReader video(folder / "camcorder.mkv");
    const Image8 image = video.ReadFrame(1);
    for (int y = 0; y < 48; ++y) {
      EXPECT_GT(image.at(25, y, 1), 200) << moved << " " << y;
      EXPECT_LT(image.at(37, y, 1), 160) << moved << " " << y;
    }
    EXPECT_EQ(video.notes().size(), moved > 0 ? 1u : 0u);
  }
}

// Those of public reports, where they are: each against the same film without its property.
TEST(Video, OfPublicReportsLooksLikeItsUprightFilm) {
  const std::string street = COSPLAT_SOURCE_DIR "/../shared/data/street/";
  if (!std::filesystem::exists(street)) GTEST_SKIP() << "the shared data are not here";
  VideoReader upright(street + "upright.mp4");
  for (const char* name : {"phone_portrait_m90.mp4",
                           "phone_portrait_p90.mp4",
                           "webrtc_smaller.webm",
                           "webrtc_larger.webm",
                           "anamorphic.mp4"}) {
    VideoReader video(street + name);
    EXPECT_NEAR(video.frames_per_second(), 25, 1) << name;
    EXPECT_GE(video.frame_count(), 39) << name;
    for (const int frame : {0, 10, 35}) {
      const Image8 image = video.ReadFrame(frame);
      const Image8 expected = upright.ReadFrame(frame);
      ASSERT_EQ(SizeText(image.width, image.height), SizeText(expected.width, expected.height))
          << name;
      EXPECT_GT(PsnrOf(image, expected), 36) << name << " " << frame;
    }
  }
  EXPECT_TRUE(VideoReader(street + "alpha.webm").has_alpha());
  const VideoReader recorded(street + "mediarecorder_vp8.webm");  // 13 frames in 1.8 s
  EXPECT_NEAR(recorded.frame_count() / recorded.frames_per_second(), 1.9, 0.2);
}

}  // namespace
}  // namespace cosplat::test
