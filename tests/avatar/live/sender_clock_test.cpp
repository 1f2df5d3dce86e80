#include "avatar/live/sender_clock.h"

#include <gtest/gtest.h>

#include <limits>

namespace cosplat {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
constexpr int64_t kMillisecond = 1'000'000;

TEST(SequenceFilter, OnlyNewerFramesUntilAPause) {
  SequenceFilter filter;
  EXPECT_TRUE(filter.Accept(5, 0));
  EXPECT_FALSE(filter.Accept(5, 1));
  EXPECT_FALSE(filter.Accept(4, 2));
  EXPECT_TRUE(filter.Accept(9, 3));
  EXPECT_FALSE(filter.Accept(0, 3 + SequenceFilter::kRestartPauseNs - 1));
  EXPECT_FALSE(filter.began_again());
  EXPECT_TRUE(filter.Accept(0, 3 + SequenceFilter::kRestartPauseNs));
  EXPECT_TRUE(filter.began_again());
  EXPECT_TRUE(filter.Accept(1, 4 + SequenceFilter::kRestartPauseNs));
}

TEST(SenderClock, RemovesTheJitterOfTheWay) {
  SenderClock clock;
  // Sent every 10 ms; under way for 1, 8, 3, 0 and 5 ms more than the fastest could.
  const int64_t delays[] = {1, 8, 3, 0, 5};
  int64_t received[5];
  for (int i = 0; i < 5; ++i) {
    const int64_t now = 100 * kSecond + (10 * i + delays[i]) * kMillisecond;
    received[i] = clock.Received(10 * i * kMillisecond, now);
    EXPECT_LE(received[i], now);
  }
  EXPECT_NEAR(double(received[1] - received[0]), 10e6, 1e5);  // the difference creeps by 1/1000
  EXPECT_NEAR(double(received[2] - received[1]), 10e6, 1e5);
  EXPECT_NEAR(double(received[4] - received[3]), 10e6, 1e5);
}

TEST(SenderClock, FollowsAClockThatGoesSlow) {
  SenderClock clock;
  for (int64_t i = 0; i < 100'000; ++i) {  // a thousand seconds, the sender's 100 ppm short
    const int64_t now = i * 10 * kMillisecond;
    ASSERT_EQ(clock.Received(now - now / 10'000, now), now) << i;
  }
}

TEST(SenderClock, FollowsAClockThatIsSet) {
  SenderClock clock;
  EXPECT_EQ(clock.Received(3600 * kSecond, 10 * kSecond), 10 * kSecond);
  EXPECT_EQ(clock.Received(0, 11 * kSecond), 11 * kSecond);  // an hour back
  EXPECT_EQ(clock.Received(kSecond, 12 * kSecond), 12 * kSecond);
  EXPECT_EQ(clock.Received(7200 * kSecond, 13 * kSecond), 13 * kSecond);  // and forth
}

TEST(SenderClock, TakesAnyNumbers) {
  constexpr int64_t kMin = std::numeric_limits<int64_t>::min();
  constexpr int64_t kMax = std::numeric_limits<int64_t>::max();
  SenderClock clock;
  for (const int64_t sent : {kMin, int64_t(0), kMax})
    for (const int64_t now : {int64_t(0), kMax}) EXPECT_LE(clock.Received(sent, now), now);
}

}  // namespace
}  // namespace cosplat
