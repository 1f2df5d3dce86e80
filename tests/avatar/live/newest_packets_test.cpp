#include "avatar/live/newest_packets.h"

#include <gtest/gtest.h>

namespace cosplat {
namespace {

TEST(NewestPackets, KeepsTheNewestInOrder) {
  NewestPackets packets(3);
  for (const std::string& text : std::vector<std::string>{"a", "b", "c"})
    EXPECT_EQ(packets.Push(text), 0u);
  EXPECT_EQ(packets.Push(std::string("d")), 1u);
  ASSERT_EQ(packets.size(), 3u);
  EXPECT_EQ(packets[0], "b");
  EXPECT_EQ(packets[2], "d");
  packets.Clear();
  EXPECT_EQ(packets.Push(std::string("e")), 0u);
  ASSERT_EQ(packets.size(), 1u);
  EXPECT_EQ(packets[0], "e");
}

TEST(NewestPackets, HoldsHalfAMegabyte) {
  NewestPackets packets(1000);
  const std::string large(100 * 1024, 'x');
  for (int i = 0; i < 5; ++i) EXPECT_EQ(packets.Push(large), 0u);
  EXPECT_EQ(packets.Push(std::string(12 * 1024, 'y')), 0u);
  EXPECT_EQ(packets.Push(large), 1u);
  EXPECT_EQ(packets.Push(std::string(300 * 1024, 'z')), 3u);
  ASSERT_EQ(packets.size(), 4u);
  EXPECT_EQ(packets[3][0], 'z');
}

}  // namespace
}  // namespace cosplat
