// `cosplat voice` and the drive `audio:`, from sounds to scores, lines and videos.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>

#include "avatar/live/json_frame.h"
#include "avatar/live/score_recording.h"
#include "avatar/live/source.h"
#include "splat/base/files.h"
#include "splat/media/sound.h"
#include "tests/integration/command.h"
#include "tests/support/spoken.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

using test::CommandResult;
using test::Cosplat;
using test::Speak;
using test::TemporaryFolder;

// Silence, "ah" from 0.4 s to 1 s, silence until 1.6 s.
std::vector<float> OneVowel() { return Speak({{{}, 0.4}, {test::kSpokenAh, 0.6}, {{}, 0.6}}); }

std::string WavOf(const TemporaryFolder& folder, const std::vector<float>& samples) {
  test::WriteWav(samples, folder / "say.wav");
  return folder / "say.wav";
}

void ExpectOneVowel(const std::vector<float>& jaw) {
  ASSERT_GE(jaw.size(), 79u);
  EXPECT_LT(*std::max_element(jaw.begin() + 10, jaw.begin() + 16), 0.12);
  EXPECT_GT(*std::min_element(jaw.begin() + 30, jaw.begin() + 46), 0.2);
  EXPECT_LT(jaw.back(), 0.15);
}

void ExpectRefused(const CommandResult& result, const std::string& problem) {
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find(problem), std::string::npos) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

// The jaw in lines as live avatars read them.
std::vector<float> JawOfLines(const std::string& text) {
  std::vector<float> jaw;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const JsonFrame frame = ParseJsonFrame("standard output", line);
    EXPECT_EQ(frame.sequence, jaw.size());
    EXPECT_NEAR(*frame.time, 0.02 * double(jaw.size()), 1e-9);
    EXPECT_TRUE(frame.dropped.empty());
    jaw.push_back(frame.blendshapes->at("jawOpen"));
  }
  return jaw;
}

TEST(Voice, WritesATableThatDrives) {
  const TemporaryFolder folder;
  const std::string table = folder / "say.csv";
  const CommandResult result = Cosplat({"voice", WavOf(folder, OneVowel()), "-o", table});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("80 frames at 50 per second"), std::string::npos) << result.out;
  const ScoreRecording recording = LoadScores(table);
  EXPECT_EQ(recording.frames_per_second, 60);
  EXPECT_EQ(recording.frames.back().timestep, 95);  // 1.58 s
  std::vector<float> jaw;
  for (const ScoredFrame& frame : recording.frames) jaw.push_back(frame.scores.at("jawOpen"));
  ExpectOneVowel(jaw);
}

TEST(Voice, SendsAFileAtThePaceAtWhichItIsSpoken) {
  const TemporaryFolder folder;
  const auto start = std::chrono::steady_clock::now();
  const CommandResult result = Cosplat({"voice", WavOf(folder, OneVowel())});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_GE(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 1.45);
  ExpectOneVowel(JawOfLines(result.out));
  // The recorded drive of `send` says the same.
  const CommandResult sent = Cosplat({"send", "audio:" + (folder / "say.wav")});
  ASSERT_EQ(sent.code, 0) << sent.err;
  EXPECT_EQ(JawOfLines(sent.out), JawOfLines(result.out));
}

TEST(Voice, HearsStandardInput) {
  const TemporaryFolder folder;
  const std::string samples = folder / "samples", sound = WavOf(folder, OneVowel());
  std::ofstream(samples, std::ios::binary) << test::SampleBytes(OneVowel()) << "x";
  const auto hear = [](const std::string& input) {
    return Cosplat({"voice", "-"}, "", COSPLAT_COMMAND, input);
  };
  const CommandResult result = hear(samples);
  ASSERT_EQ(result.code, 0) << result.err;
  ExpectOneVowel(JawOfLines(result.out));
  ExpectRefused(hear(sound), "standard input: is a sound file; expected samples of 16 bits");
  ExpectRefused(hear("/dev/null"), "standard input: has no sound");
}

// Programs that record, for PATH.
TEST(Voice, HearsAMicrophoneByWhatRecordsIt) {
  const TemporaryFolder folder;
  MakeDirectories(folder / "bin");
  std::ofstream(folder / "samples", std::ios::binary) << test::SampleBytes(OneVowel());
  const auto hear = [&](const std::string& body) {
    const std::string program = folder / "bin/parec";
    std::ofstream(program) << "#!/bin/sh\n" << body << "\n";
    fs::permissions(program, fs::perms::owner_all);
    return Cosplat({"voice"}, "PATH='" + (folder / "bin") + "'");
  };
  const CommandResult result = hear(
      "[ \"$1 $2\" = '--rate=16000 --channels=1' ] && while IFS= read -r x; do :; done </dev/null;"
      " /bin/cat '" +
      (folder / "samples") + "'; echo lost >&2; exit 3");
  EXPECT_EQ(result.code, 2);
  ExpectOneVowel(JawOfLines(result.out));
  EXPECT_NE(result.err.find("the microphone, by parec\n"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("parec: exited with status 3"), std::string::npos) << result.err;
  fs::remove(folder / "bin/parec");
  ExpectRefused(Cosplat({"voice"}, "PATH='" + (folder / "bin") + "'"),
                "the microphone: needs parec (Debian: pulseaudio-utils)");
}

TEST(Voice, AMutedMicrophoneIsSaid) {
  const TemporaryFolder folder;
  std::ofstream(folder / "samples", std::ios::binary) << std::string(6 * 32000, '\0');
  const CommandResult result = Cosplat({"voice", "-"}, "", COSPLAT_COMMAND, folder / "samples");
  EXPECT_EQ(result.code, 0);
  EXPECT_NE(result.err.find("nothing but zeros for 5 s: is it muted?"), std::string::npos);
  for (const float jaw : JawOfLines(result.out)) EXPECT_LT(jaw, 0.1);
}

TEST(Voice, WhatCannotBeHeardIsOneLineAndNothingIsWritten) {
  const TemporaryFolder folder;
  const std::string sound = WavOf(folder, OneVowel()), table = folder / "say.csv";
  ExpectRefused(Cosplat({"voice", folder / "no.wav", "-o", table}), "cannot be opened as a sound");
  ExpectRefused(Cosplat({"voice", sound, "-o", folder / "say.txt"}), "is no .csv");
  ExpectRefused(Cosplat({"voice", "-o", table}), "--out: needs a sound file");
  ExpectRefused(Cosplat({"voice", sound, "-o", table, "--to", "udp://:9500"}), "excludes --to");
  ExpectRefused(Cosplat({"voice", WavOf(folder, std::vector<float>(50)), "-o", table}),
                "has no sound that lasts");
  ExpectRefused(Cosplat({"voice", WavOf(folder, std::vector<float>(16000)), "-o", table}),
                "is silent: nobody is heard in it");
  ExpectRefused(Cosplat({"voice", folder / "say.wav"}), "is silent: nobody is heard in it");
  EXPECT_FALSE(fs::exists(table));
}

// A talking video: it has the sound, lasts as long, and a table's rate is the video's.
TEST(Voice, RendersATalkingVideo) {
  const TemporaryFolder folder;
  const std::string out = folder / "out", video = folder / "talk.mp4";
  ASSERT_EQ(test::MakeSmallAvatar(folder), "");
  const std::string sound = WavOf(folder, OneVowel());
  const CommandResult rendered =
      Cosplat({"render", "-m", out, "--drive", "audio:" + sound, "-o", video});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const VideoReader reader(video);
  EXPECT_EQ(reader.frame_count(), 80);
  EXPECT_NEAR(reader.frames_per_second(), 50, 1e-3);
  EXPECT_NEAR(double(ReadSound(video, 16000, 1).samples.size()) / 16000, 1.6, 0.1);
  const std::string played = folder / "played.mp4";
  ASSERT_EQ(Cosplat({"play", out, "--drive", "audio:" + sound, "--headless", "-o", played}).code,
            0);
  EXPECT_NEAR(double(ReadSound(played, 16000, 1).samples.size()) / 16000, 1.6, 0.1);
  // At its table's own rate: no slow motion of it.
  ASSERT_EQ(Cosplat({"voice", sound, "-o", folder / "say.csv"}).code, 0);
  ASSERT_EQ(
      Cosplat({"render", "-m", out, "--drive", folder / "say.csv", "-o", folder / "b.mp4"}).code,
      0);
  EXPECT_NEAR(VideoReader(folder / "b.mp4").frames_per_second(), 60, 1e-3);
  EXPECT_EQ(VideoReader(folder / "b.mp4").frame_count(), 96);
  ExpectRefused(
      Cosplat(
          {"render", "-m", out, "--drive", "audio:" + (folder / "no.wav"), "-o", folder / "c.mp4"}),
      "no.wav: cannot be opened as a sound");
  EXPECT_FALSE(fs::exists(folder / "c.mp4"));
}

// A recorded man of flite's, whom the network learned from, too: his jaw against the phonemes, and
// the lips at p, b and m. (Of people whom it did not: assets/voice/make_voice_net.py --hold.)
TEST(Voice, HearsPeople) {
  if (std::system("flite --version >/dev/null 2>&1") == 127 << 8) GTEST_SKIP() << "no flite";
  const TemporaryFolder folder;
  const std::string text = "Maybe Bob and Mary buy a big apple pie. My mother saw a warm room.";
  const std::string sound = folder / "say.wav", table = folder / "say.csv";
  ASSERT_EQ(std::system(("flite -voice rms -psdur -t '" + text + "' -o '" + sound + "' >'" +
                         (folder / "phonemes") + "'")
                            .c_str()),
            0);
  ASSERT_EQ(Cosplat({"voice", sound, "-o", table}).code, 0);
  const ScoreRecording recording = LoadScores(table);
  std::istringstream phonemes(test::Slurp(folder / "phonemes"));
  double begin = 0, open = 0, shut = 0;
  int vowels = 0, consonants = 0, closures = 0, closed = 0;
  for (std::string token; phonemes >> token;) {
    const size_t colon = token.find(':');
    const std::string name = token.substr(0, colon);
    const double end = std::stod(token.substr(colon + 1));
    float least = 1, sum = 0;
    int count = 0;
    for (const ScoredFrame& frame : recording.frames) {
      const double t = 0.01 + double(frame.timestep) / recording.frames_per_second;
      if (t < begin - 0.02 || t > end + 0.02) continue;
      const float jaw = frame.scores.at("jawOpen");
      least = std::min(least, jaw);
      sum += jaw;
      ++count;
    }
    if (name == "p" || name == "b" || name == "m") {
      ++closures;
      closed += least < 0.05f;
    }
    if (name == "aa" || name == "ae" || name == "ay" || name == "ao") open += sum / count, ++vowels;
    if (name == "s" || name == "pau" || name == "b") shut += sum / count, ++consonants;
    begin = end;
  }
  ASSERT_GE(closures, 10);
  EXPECT_GE(closed, 8 * closures / 10);
  EXPECT_GT(open / vowels, 2 * shut / consonants);
}

}  // namespace
}  // namespace cosplat
