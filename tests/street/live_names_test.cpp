// The 52 names of ARKit as programs spell them, wherever names come in.
#include <gtest/gtest.h>

#include <cctype>
#include <set>

#include "avatar/live/recording.h"
#include "avatar/model/blendshape_map.h"
#include "flame/io/landmarks.h"
#include "tests/street/live_source.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using Words = std::vector<std::string>;

// "eyeLookInLeft" -> eye, look, in, left.
Words WordsOf(std::string_view name) {
  Words words(1);
  for (const char c : name) {
    if (std::isupper(c)) words.emplace_back();
    words.back() += char(std::tolower(c));
  }
  return words;
}

std::string Upper(std::string text) {
  for (char& c : text) c = char(std::toupper(c));
  return text;
}

std::string Joined(const Words& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

Words Capitalised(Words words) {
  for (std::string& word : words) word[0] = char(std::toupper(word[0]));
  return words;
}

// Every spelling that we know of; the first is ARKit's.
Words SpellingsOf(std::string_view name) {
  const Words words = WordsOf(name), large = Capitalised(words);
  const std::string camel(name), pascal = Joined(large, "");
  Words all{camel, pascal, Upper(camel), Joined(words, "")};
  for (const char* separator : {"_", "-", " ", "."})
    for (const Words& each : {words, large}) {
      all.push_back(Joined(each, separator));
      all.push_back(Upper(all.back()));
    }
  const std::string side = words.back();
  if (side != "left" && side != "right") return all;
  const std::string letter(1, side[0]);
  Words rest = words;
  rest.pop_back();
  const std::string stem = camel.substr(0, camel.size() - side.size());  // "mouthSmile"
  for (const std::string& each : {letter, Upper(letter), side, large.back()})
    for (const char* separator : {"_", "-", " ", "."}) {
      all.push_back(stem + separator + each);  // iFacialMocap, ARKit's constants
      all.push_back(each + separator + stem);
      all.push_back(Joined(rest, "_") + separator + each);
      all.push_back(Upper(stem) + separator + each);
    }
  all.push_back(stem + Upper(letter));
  // "Eye_Left_Blink"
  Words inner = Capitalised(rest);
  inner.insert(inner.begin() + 1, large.back());
  all.push_back(Joined(inner, "_"));
  return all;
}

TEST(StreetLiveNames, AllSpellingsOfThe52AreFound) {
  std::set<std::string> normal;
  size_t tried = 0;
  for (size_t i = 0; i < kArkitNames.size(); ++i) {
    normal.insert(NormalName(kArkitNames[i]));
    for (const std::string& spelling : SpellingsOf(kArkitNames[i])) {
      EXPECT_EQ(FindArkitBlendshape(spelling), int(i)) << spelling;
      EXPECT_EQ(ArkitSpelling(spelling), kArkitNames[i]) << spelling;
      ++tried;
    }
  }
  EXPECT_EQ(normal.size(), kArkitNames.size()) << "two are the same name";
  EXPECT_GT(tried, 2000u);
}

TEST(StreetLiveNames, WhatIsNearIsNotTaken) {
  for (const char* name : {"",
                           "_",
                           "left",
                           "jaw",
                           "jawOpen1",
                           "mouthLeft_R",
                           "mouthSmile",
                           "browInnerUpLeft",
                           "mouthFunne_L",
                           "cheekPuff_L",
                           "A",
                           "Joy",
                           "Blink_L",
                           "jawOpen\xff"})
    EXPECT_EQ(FindArkitBlendshape(name), -1) << name;
}

TEST(StreetLiveNames, ByVmcAndJson) {
  for (const std::string& name : SpellingsOf("eyeBlinkLeft")) {
    FlameModel flame;
    flame.expression_count = 4;
    flame.has_eyelids = true;
    LiveSourceOptions options;
    options.flame = &flame;
    test::LiveConnection vmc("vmc", options), json("udp", options);
    vmc.Send(test::OscBundle({test::VmcValue(name, 0.75f), test::VmcApply()}));
    json.Send(R"({"seq": 1, "blendshapes": {")" + name + R"(": 0.75}})");
    for (test::LiveConnection* each : {&vmc, &json}) {
      ASSERT_TRUE(each->Poll());
      EXPECT_EQ(each->frame.params.expression, (std::vector<float>{0, 0, 0.75f, 0})) << name;
      EXPECT_EQ(each->Notes(), "") << name;
    }
  }
}

TEST(StreetLiveNames, InRecordingsAndInAnAvatarsOwnMap) {
  const test::TemporaryFolder folder;
  for (const char* recorded : {"jaw_open", "JawOpen", "JAWOPEN"}) {
    LandmarkVideo video;
    video.width = video.height = 100;
    video.set = LandmarkSet::kIbug68;
    DetectedFace face;
    face.points.assign(68, {50, 50});
    face.blendshapes[recorded] = 0.5f;
    video.frames.push_back({"0", 0, {face}, ""});
    WriteLandmarks(folder / "marks.json", video);
    EXPECT_FLOAT_EQ(LoadRecording(folder / "marks.json", {}).frames[0].params.pose[2][0], 0.25f);

    BlendshapeMap own = GeneralBlendshapeMap(nullptr);
    own.names[0] = "Jaw_Open";
    LiveSourceOptions options;
    options.blendshapes = &own;
    EXPECT_FLOAT_EQ(LoadRecording(folder / "marks.json", options).frames[0].params.pose[2][0],
                    0.25f);
    own.names[1] = recorded;
    EXPECT_NE(ProblemOf(own), "") << "the same name twice";
  }
}

}  // namespace
}  // namespace cosplat
