#include <gtest/gtest.h>

#include <fstream>

#include "avatar/live/recording.h"
#include "avatar/live/score_recording.h"
#include "tests/avatar/live/phone_packets.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

const char* const kHeader = "Timecode,BlendShapeCount,JawOpen,HeadYaw,HeadPitch,HeadRoll\n";

std::string Written(const TemporaryFolder& folder, const std::string& text) {
  const std::string path = folder / "take.csv";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

TEST(LiveLinkRecording, FacesAtTheirTimesWithTheirHeads) {
  const TemporaryFolder folder;
  LiveSourceOptions options;
  options.rest.translation = {0, 0, 3};
  const Recording recording = LoadRecording(Written(folder, test::LiveLinkTable()), options);
  EXPECT_EQ(recording.frames_per_second, 60);
  ASSERT_EQ(recording.frames.size(), 3u);  // without the row that has no scores
  EXPECT_EQ(recording.frames[0].timestep, 0);
  EXPECT_EQ(recording.frames[1].timestep, 3);  // 58 to 60.5
  EXPECT_EQ(recording.frames[2].timestep, 62);
  const FlameParams& first = recording.frames[0].params;
  EXPECT_FLOAT_EQ(first.pose[2][0], 0.25f);     // by the general map
  EXPECT_NEAR(first.pose[0][1], -0.1f, 1e-6f);  // to the right
  EXPECT_EQ(first.translation[2], 3);
  const FlameParams& second = recording.frames[1].params;
  EXPECT_FLOAT_EQ(second.pose[2][1], -0.1f);
  EXPECT_NEAR(second.pose[0][0], 0.1f, 0.02f);  // down
  EXPECT_NEAR(second.pose[0][2], 0.2f, 0.02f);  // to the right shoulder
}

TEST(LiveLinkRecording, TimecodesOfOtherRatesAndOverMidnight) {
  const TemporaryFolder folder;
  // A phone that records every other frame of its clock, and Windows' line ends.
  std::string text = std::string("\xef\xbb\xbf") + kHeader;
  text.insert(text.size() - 1, "\r");
  text +=
      "23:59:59:56.000,61,1,0,0,0\r\n23:59:59:58.000,61,1,0,0,0\r\n"
      "00:00:00:00.000,61,1,0,0,0\r\n00:00:01:00.000,61,1,0,0,0\r\n"
      "00:00:02:00.000,61,1,0,0,0\r\n";
  ScoreRecording recording = LoadScores(Written(folder, text));
  EXPECT_EQ(recording.frames_per_second, 30);
  ASSERT_EQ(recording.frames.size(), 5u);
  const int64_t expected[] = {0, 1, 2, 32, 62};
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(recording.frames[i].timestep, expected[i]);
  // 24 frames a second, of which some come twice.
  text = kHeader;
  for (int second = 0; second < 3; ++second)
    for (int frame = 0; frame < 48; ++frame)
      text += Format("10:00:{:02d}:{:02d}.{}00,61,{},0,0,0\n",
                     second,
                     frame / 2,
                     frame % 2 * 4,
                     frame % 2 * 0.5);
  recording = LoadScores(Written(folder, text));
  EXPECT_EQ(recording.frames_per_second, 24);
  ASSERT_EQ(recording.frames.size(), 72u);
  EXPECT_EQ(recording.frames[71].timestep, 71);
  EXPECT_EQ(recording.frames[71].scores.at("jawOpen"), 0.5f);  // the later one
  // 15, as slow devices have.
  text = kHeader;
  for (int i = 0; i < 45; ++i) text += Format("10:00:{:02d}:{:02d},61,0,0,0,0\n", i / 15, i % 15);
  recording = LoadScores(Written(folder, text));
  EXPECT_EQ(recording.frames_per_second, 15);
  EXPECT_EQ(recording.frames.back().timestep, 44);
}

TEST(LiveLinkRecording, ErrorsNameLineColumnAndValue) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& text, const std::vector<std::string>& parts) {
    const std::string path = Written(folder, text);
    ExpectError([&] { LoadScores(path); }, parts);
  };
  const std::string header = kHeader, row = "10:00:00:00.000,61,0.5,0,0,0\n";
  expect("a,b\n1,2\n", {"take.csv", "Timecode", "is no column"});
  expect("", {"take.csv", "Timecode"});
  expect("Timecode,BlendShapeCount,JawOpen\n" + row, {"HeadPitch", "is no column"});
  expect(header, {"take.csv", "no row has scores"});
  expect(header + "10:00:00:00.000,0\n", {"no row has scores"});
  expect(header + row + "10:00:00:01.000,61,0.5\n", {"line 3", "has 3 cells, expected 6"});
  expect(header + row + "10:00:00:01.000,61,x,0,0,0\n", {"line 3, JawOpen", "found 'x'"});
  expect(header + "10:00:00:01.000,61,40,0,0,0\n", {"line 2, JawOpen", "found '40'"});
  expect(header + "10:00:00:01.000,61,nan,0,0,0\n", {"line 2, JawOpen", "found 'nan'"});
  expect(header + "10:00:00:01.000,61,0,0,9,0\n", {"line 2, HeadPitch", "found '9'"});
  expect(header + "10:00:00:01.000,61,0,0,2,0\n", {"line 2, HeadPitch", "found '2'", "radians"});
  for (const char* time :
       {"", "10:00", "25:00:00:00", "10:60:00:00", "10:00:00:00:1", "10:00:00:61"})
    expect(header + time + ",61,0,0,0,0\n", {"line 2, Timecode", time});
  expect(header + row + "09:00:00:00.000,61,0,0,0,0\n", {"line 3, Timecode", "earlier"});
  ExpectError([&] { LoadScores(folder / "none.csv"); }, {"none.csv", "cannot be read"});
}

TEST(LiveLinkRecording, SaysWhatItLacks) {
  const TemporaryFolder folder;
  EXPECT_TRUE(IsScoreRecording("TAKE.CSV"));
  const std::string row = ",61,0.5,0,0,0\n", empty = ",0,0,0,0,0\n";
  const std::string text =
      kHeader + ("10:00:00:00" + row) + ("10:00:00:01" + row) + ("10:00:00:02" + empty);
  const std::vector<std::string> notes = LoadScores(Written(folder, text)).notes;
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].find("has no column EyeBlinkLeft, "), 0u) << notes[0];
  EXPECT_EQ(notes[1], "1 of 3 rows have no face");
  const std::string unknown = "Timecode,BlendShapeCount,b0,HeadPitch,HeadYaw,HeadRoll\n10:00:00:00";
  ExpectError([&] { LoadScores(Written(folder, unknown + row)); }, {"no blendshape's column"});
  const std::string odd = kHeader + ("10:00:00:00" + row) + "10:00:20:00,61,0.5,0,1.5,0\n";
  const std::vector<std::string> of_odd = LoadScores(Written(folder, odd)).notes;
  ASSERT_EQ(of_odd.size(), 3u);
  EXPECT_EQ(of_odd[1], "has no face for 20 s: the last one is held");
  EXPECT_EQ(of_odd[2], "turns the head by 86 degrees: are its angles in radians?");
  std::string still = kHeader;
  for (int i = 0; i < 20; ++i) still += "00:00:00:00.000" + row;
  ExpectError([&] { LoadScores(Written(folder, still)); },
              {"Timecode", "1 times for 20 rows", "no clock"});
}

TEST(LiveLinkRecording, WhatIsWrittenIsRead) {
  const TemporaryFolder folder;
  ScoreRecording recording;
  recording.frames_per_second = 50;
  for (int64_t i = 0; i < 7000; ++i)
    if (i % 100 != 7)
      recording.frames.push_back(
          {i, {{"jawOpen", float(i % 50) / 50}, {"mouthLeft", 0.25f}}, {0.1f, -0.2f, 0.3f}});
  WriteLiveLinkRecording(recording, folder / "a.csv");
  const ScoreRecording read = LoadScores(folder / "a.csv");
  EXPECT_EQ(read.frames_per_second, 60);
  ASSERT_EQ(read.frames.size(), recording.frames.size());
  for (size_t i = 0; i < read.frames.size(); ++i) {
    const ScoredFrame& frame = read.frames[i];
    EXPECT_NEAR(double(frame.timestep) / 60, double(recording.frames[i].timestep) / 50, 0.51 / 60);
    EXPECT_NEAR(frame.scores.at("jawOpen"), recording.frames[i].scores.at("jawOpen"), 1e-5);
    EXPECT_NEAR(frame.scores.at("mouthLeft"), 0.25, 1e-6);
    EXPECT_EQ(frame.scores.at("mouthRight"), 0);
    for (size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(frame.head[axis], recording.frames[i].head[axis], 1e-5);
  }
  recording.frames_per_second = 120;
  ExpectError([&] { WriteLiveLinkRecording(recording, folder / "b.csv"); },
              {"b.csv", "120", "timecodes of 60"});
}

}  // namespace
}  // namespace cosplat
