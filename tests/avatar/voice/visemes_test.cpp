#include "avatar/voice/visemes.h"

#include <gtest/gtest.h>

#include "flame/blendshape_names.h"

namespace cosplat {
namespace {

VisemeWeights Only(Viseme viseme, float weight = 1, Viseme rest = kSilent) {
  VisemeWeights weights{};
  weights[rest] = 1 - weight;
  weights[viseme] += weight;
  return weights;
}
float Score(const VisemeWeights& weights, const char* name, float effort = 1) {
  return ScoresOfVisemes(weights, effort).at(name);
}

TEST(VisemeScores, AreArkitsAndFrom0To1) {
  for (int viseme = 0; viseme < kVisemes; ++viseme)
    for (const auto& [name, score] : ScoresOfVisemes(Only(Viseme(viseme)), 3)) {
      EXPECT_GE(FindArkitBlendshape(name), 0) << name;
      EXPECT_GE(score, 0);
      EXPECT_LE(score, 1);
    }
}

TEST(VisemeScores, JawLipsAndTheirOrder) {
  EXPECT_EQ(Score(Only(kSilent), "jawOpen"), 0);
  EXPECT_GT(Score(Only(kAA), "jawOpen"), Score(Only(kE), "jawOpen"));
  EXPECT_GT(Score(Only(kE), "jawOpen"), Score(Only(kIH), "jawOpen"));
  EXPECT_GT(Score(Only(kIH), "jawOpen"), Score(Only(kSS), "jawOpen"));
  EXPECT_GT(Score(Only(kOU), "mouthPucker"), Score(Only(kOH), "mouthPucker"));
  EXPECT_GT(Score(Only(kIH), "mouthStretchLeft"), 0.1);
  EXPECT_EQ(Score(Only(kOU), "mouthStretchLeft"), 0);
  EXPECT_GT(Score(Only(kAA), "jawOpen", 1.2f), Score(Only(kAA), "jawOpen"));
}

// Half of the evidence for an m between two open vowels: the lips meet, since lips that almost meet
// are what one sees as wrong.
TEST(VisemeScores, LipsThatAreHeardToShutDo) {
  EXPECT_EQ(Score(Only(kPP, 0.5f, kAA), "jawOpen"), 0);
  EXPECT_EQ(Score(Only(kPP, 0.5f, kAA), "mouthLowerDownLeft"), 0);
  EXPECT_GT(Score(Only(kPP, 0.5f, kAA), "mouthPressLeft"), 0.2);
  // A trace of it does nothing.
  EXPECT_GT(Score(Only(kPP, 0.1f, kAA), "jawOpen"), 0.4);
}

}  // namespace
}  // namespace cosplat
