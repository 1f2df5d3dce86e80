// Sound files, and the sound of videos.
#include "splat/media/sound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "splat/media/image_io.h"
#include "splat/media/libav.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

template <class T>
void Append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A WAV of 16 bits; channel c is a tone of 440 (c + 1) Hz.
std::string Wav(int rate, int channels, double seconds) {
  const auto count = uint32_t(rate * seconds);
  const uint32_t size = count * uint32_t(channels) * 2;
  std::string bytes = "RIFF";
  Append(bytes, 36 + size);
  bytes += "WAVEfmt ";
  Append(bytes, uint32_t(16));
  Append(bytes, uint16_t(1));
  Append(bytes, uint16_t(channels));
  Append(bytes, uint32_t(rate));
  Append(bytes, uint32_t(rate * channels * 2));
  Append(bytes, uint16_t(channels * 2));
  Append(bytes, uint16_t(16));
  bytes += "data";
  Append(bytes, size);
  for (uint32_t i = 0; i < count; ++i)
    for (int c = 0; c < channels; ++c)
      Append(bytes,
             int16_t(16000 * std::sin(2 * std::numbers::pi * 440 * (c + 1) * double(i) / rate)));
  return bytes;
}

std::string Written(const TemporaryFolder& folder, const std::string& name, const std::string& b) {
  std::ofstream(folder / name, std::ios::binary) << b;
  return folder / name;
}

// Amplitude of a tone in one channel, over the middle of the sound.
double Tone(const Sound& sound, double hertz, int channel = 0) {
  const auto channels = size_t(sound.channels);
  const size_t total = sound.samples.size() / channels;
  double real = 0, imaginary = 0;
  for (size_t i = total / 4; i < 3 * total / 4; ++i) {
    const double angle = 2 * std::numbers::pi * hertz * double(i) / sound.rate;
    const double x = double(sound.samples[i * channels + size_t(channel)]);
    real += x * std::cos(angle);
    imaginary += x * std::sin(angle);
  }
  return 4 * std::hypot(real, imaginary) / double(total);
}

TEST(Sound, AnyRateAndChannelsBecomeTheOnesAsked) {
  const TemporaryFolder folder;
  for (const int rate : {8000, 16000, 44100, 96000})
    for (const int channels : {1, 2}) {
      const Sound sound = ReadSound(Written(folder, "a.wav", Wav(rate, channels, 0.5)), 16000, 1);
      EXPECT_EQ(sound.rate, 16000);
      EXPECT_EQ(sound.channels, 1);
      EXPECT_NEAR(double(sound.samples.size()), 8000, 40) << rate;
      // Two channels are mixed.
      EXPECT_NEAR(Tone(sound, 440), 16000.0 / 32768 / channels, 0.02) << rate << ", " << channels;
      EXPECT_NEAR(Tone(sound, 880), channels == 2 ? 0.244 : 0, 0.02);
    }
}

TEST(Sound, OfAVideoIsWhatWasWrittenAndAsLongAsIts) {
  const TemporaryFolder folder;
  const Sound sound = ReadSound(Written(folder, "a.wav", Wav(44100, 2, 3)), 48000, 2);
  const std::string path = folder / "talk.mp4";
  VideoWriter writer(path, 64, 48, 50, sound);
  for (int i = 0; i < 100; ++i) writer.Write(Image8(64, 48, 3));
  writer.Finish();
  const VideoReader video(path);
  EXPECT_EQ(video.frame_count(), 100);
  EXPECT_NEAR(video.frames_per_second(), 50, 1e-3);
  const Sound back = ReadSound(path, 48000, 2);
  // The video ends after 2 s, its sound within a packet of it.
  EXPECT_NEAR(double(back.samples.size()) / 2 / 48000, 2, 0.06);
  EXPECT_NEAR(Tone(back, 440, 0), 0.488, 0.03);
  EXPECT_NEAR(Tone(back, 880, 1), 0.488, 0.03);
  EXPECT_LT(Tone(back, 880, 0), 0.03);
}

TEST(Sound, WhatIsNoSoundIsRefused) {
  const TemporaryFolder folder;
  const auto expect = [](const std::string& path, const std::string& problem) {
    ExpectError([&] { ReadSound(path, 16000, 1); }, {path, problem});
  };
  expect(folder / "absent.wav", "cannot be opened as a sound");
  expect(Written(folder, "text.wav", "no sound at all"), "cannot be opened as a sound");
  expect(Written(folder, "empty.wav", Wav(16000, 1, 0)), "has no sound that can be decoded");
  const std::string silent = folder / "silent.mp4";
  VideoWriter writer(silent, 64, 48, 25);
  writer.Write(Image8(64, 48, 3));
  writer.Finish();
  expect(silent, "has no audio track");
}

TEST(Sound, ACutFileGivesWhatItHas) {
  const TemporaryFolder folder;
  const std::string whole = Wav(16000, 1, 1);
  const Sound sound =
      ReadSound(Written(folder, "cut.wav", whole.substr(0, whole.size() / 2)), 16000, 1);
  EXPECT_NEAR(double(sound.samples.size()), 8000, 300);
}

// A copy of a file whose sound begins so much later.
void DelaySound(const std::string& from, const std::string& to, double seconds) {
  const libav::Input input = libav::OpenInput(from, "video");
  AVFormatContext* output = nullptr;
  ASSERT_GE(avformat_alloc_output_context2(&output, nullptr, nullptr, to.c_str()), 0);
  for (unsigned i = 0; i < input->nb_streams; ++i) {
    AVCodecParameters* track = avformat_new_stream(output, nullptr)->codecpar;
    avcodec_parameters_copy(track, input->streams[i]->codecpar);
    track->codec_tag = 0;  // the other container's
  }
  ASSERT_GE(avio_open(&output->pb, to.c_str(), AVIO_FLAG_WRITE), 0);
  ASSERT_GE(avformat_write_header(output, nullptr), 0);
  const libav::Packet packet{av_packet_alloc()};
  while (av_read_frame(input.get(), packet.get()) >= 0) {
    const AVStream& track = *input->streams[packet->stream_index];
    av_packet_rescale_ts(
        packet.get(), track.time_base, output->streams[packet->stream_index]->time_base);
    if (track.codecpar->codec_type == AVMEDIA_TYPE_AUDIO) {
      const auto late = int64_t(seconds / av_q2d(output->streams[packet->stream_index]->time_base));
      packet->pts += late, packet->dts += late;
    }
    ASSERT_GE(av_interleaved_write_frame(output, packet.get()), 0);
  }
  av_write_trailer(output);
  avio_closep(&output->pb);
  avformat_free_context(output);
}

// a.mp4, of so many seconds of sound and of picture.
void WriteTalk(const TemporaryFolder& folder, double sound, int picture) {
  constexpr int kRate = 48000, kFrames = 25;
  VideoWriter writer(folder / "a.mp4",
                     64,
                     48,
                     kFrames,
                     ReadSound(Written(folder, "a.wav", Wav(kRate, 1, sound)), kRate, 1));
  for (int i = 0; i < picture * kFrames; ++i) writer.Write(Image8(64, 48, 3));
  writer.Finish();
}

TEST(Sound, OfAVideoMayBeginLater) {
  const TemporaryFolder folder;
  WriteTalk(folder, 2, 2);
  DelaySound(folder / "a.mp4", folder / "late.mkv", 0.5);
  const Sound late = ReadSound(folder / "late.mkv", 16000, 1);
  const auto loud = std::find_if(
      late.samples.begin(), late.samples.end(), [](float x) { return std::abs(x) > 0.2f; });
  EXPECT_NEAR(double(loud - late.samples.begin()) / 16000, 0.5, 0.05);
}

TEST(Sound, MayEndBeforeThePicture) {
  const TemporaryFolder folder;
  WriteTalk(folder, 1, 3);
  const Sound back = ReadSound(folder / "a.mp4", 16000, 1);
  EXPECT_TRUE(back.notes.empty()) << back.notes[0];
}

// Sun's .au states how many bytes follow.
TEST(Sound, SaysThatItIsCutOff) {
  const TemporaryFolder folder;
  const uint32_t rate = 8000, bytes = 2 * 3 * rate;
  std::string file = ".snd";
  for (const uint32_t field : {24u, bytes, 3u, rate, 1u})
    for (int shift = 24; shift >= 0; shift -= 8) file += char(field >> shift);
  file += std::string(bytes, '\1');
  EXPECT_TRUE(ReadSound(Written(folder, "a.au", file), 16000, 1).notes.empty());
  const Sound cut = ReadSound(Written(folder, "b.au", file.substr(0, bytes / 2)), 16000, 1);
  ASSERT_EQ(cut.notes.size(), 1u);
  EXPECT_NE(cut.notes[0].find("it is to be 3.0 s long, 1.5 s"), std::string::npos) << cut.notes[0];
}

}  // namespace
}  // namespace cosplat
