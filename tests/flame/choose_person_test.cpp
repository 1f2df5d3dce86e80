#include "flame/fit/choose_person.h"

#include <gtest/gtest.h>

namespace cosplat {
namespace {

FaceBox BoxAt(double x, double y, double size) {
  return {x - size / 2, y - size / 2, x + size / 2, y + size / 2};
}

// Two people beside each other, of whom now one and now the other is a little larger, and found
// first; in some frames one of them is not found.
TEST(ChoosePerson, StaysWithOneOfTwo) {
  std::vector<std::vector<FaceBox>> boxes;
  std::vector<std::optional<size_t>> right;
  for (int f = 0; f < 60; ++f) {
    const FaceBox a = BoxAt(300 + f, 200, 105 + 8 * (f % 3));
    const FaceBox b = BoxAt(600 - f, 210, 100 + 8 * ((f + 1) % 3));
    if (f % 10 == 4) {
      boxes.push_back({b});
      right.push_back(std::nullopt);
    } else if (f % 10 == 7) {
      boxes.push_back({a});
      right.push_back(0);
    } else if (f % 2 == 0) {
      boxes.push_back({a, b});
      right.push_back(0);
    } else {
      boxes.push_back({b, a});
      right.push_back(1);
    }
  }
  const Person person = ChoosePerson(boxes);
  EXPECT_EQ(person.face, right);
  EXPECT_FALSE(person.is_alone);
  for (size_t f = 0; f < boxes.size(); ++f) {
    ASSERT_EQ(person.others[f].size(), f % 10 == 7 ? 0u : 1u) << f;
    if (f % 10 != 7) {
      EXPECT_GT(person.others[f][0].left, 450) << f;
    }
  }
  // The other one was seen before.
  const Person other = ChoosePerson(boxes, std::vector<FaceBox>(60, BoxAt(560, 200, 110)));
  for (size_t f = 0; f < boxes.size(); ++f) {
    EXPECT_EQ(other.face[f].has_value(), f % 10 != 7) << f;
    if (other.face[f]) {
      EXPECT_GT(boxes[f][*other.face[f]].left, 450) << f;
    }
  }
}

// A face on the wall that is found once, which the head passes later; and one face that was found
// twice, in overlapping windows.
TEST(ChoosePerson, OneHeadIsOneWhereverItGoes) {
  std::vector<std::vector<FaceBox>> boxes;
  for (int f = 0; f < 40; ++f) boxes.push_back({BoxAt(100 + 20 * f, 300, 100)});
  boxes[2].push_back(BoxAt(700, 300, 60));
  boxes[9].insert(boxes[9].begin(), BoxAt(284, 302, 90));
  boxes[20].clear();
  const Person person = ChoosePerson(boxes);
  for (size_t f = 0; f < boxes.size(); ++f) {
    if (f == 20)
      EXPECT_FALSE(person.face[f]);
    else
      EXPECT_EQ(person.face[f], f == 9 ? 1u : 0u) << f;
  }
  EXPECT_TRUE(person.is_alone);
  EXPECT_TRUE(person.others[2].empty());
}

// Someone comes in for half of the video, and near.
TEST(ChoosePerson, WhoStaysComesFirst) {
  std::vector<std::vector<FaceBox>> boxes(40, {BoxAt(100, 300, 100)});
  for (size_t f = 20; f < 40; ++f) boxes[f].insert(boxes[f].begin(), BoxAt(600, 300, 300));
  const Person person = ChoosePerson(boxes);
  for (size_t f = 0; f < boxes.size(); ++f) EXPECT_EQ(person.face[f], f < 20 ? 0u : 1u) << f;
  EXPECT_FALSE(person.is_alone);
}

TEST(ChoosePerson, NobodyIsNobody) {
  EXPECT_TRUE(ChoosePerson({}).face.empty());
  EXPECT_FALSE(ChoosePerson({{}, {}}).face[1]);
}

TEST(KeepPerson, LeavesOneFace) {
  const auto face = [](double x, double size) {
    return DetectedFace{{{x, 0}, {x + size, size}}, 1, {}};
  };
  std::vector<std::vector<DetectedFace>> frames(5, {face(0, 50), face(200, 80)});
  frames[3] = {face(1, 50)};
  EXPECT_FALSE(KeepPerson(frames).is_alone);
  for (size_t f = 0; f < 5; ++f) {
    ASSERT_EQ(frames[f].size(), f == 3 ? 0u : 1u) << f;
    if (f != 3) {
      EXPECT_EQ(frames[f][0].points[0][0], 200);
    }
  }
}

}  // namespace
}  // namespace cosplat
