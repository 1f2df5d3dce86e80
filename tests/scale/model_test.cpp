// The model of a step's time: known cases, and that it reads what a run writes.
#include "tests/scale/model.h"

#include <gtest/gtest.h>

#include <fstream>

#include "splat/base/json.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::scale {
namespace {

Measured Example() { return {1e-8, 2e-8, 5e-7, 3e-8, 4e-8, 0.25, 0.5, 1e5, 1e5, 4}; }

TEST(ScaleModel, HalvesWhatRanksShareAndAddsTheExchange) {
  const Measured m = Example();
  const Training t = TrainingOf(m);
  const StepTime one = TimeOf(m, t, {1, 1e9}), two = TimeOf(m, t, {2, 1e9, 0});
  EXPECT_DOUBLE_EQ(one.drawing, 4 * (5e-4 + 5e-2));
  EXPECT_DOUBLE_EQ(two.drawing, one.drawing / 2);
  EXPECT_DOUBLE_EQ(two.own_share, one.own_share / 2);
  EXPECT_EQ(one.bytes, 0);
  EXPECT_EQ(one.exchange, 0);
  // Four views of 25,000 Gaussians, half of which are another rank's: 17 floats there, 9 back.
  const double expected = 4 * (25000 * 0.5) * 4 * (17 + 9);
  EXPECT_NEAR(two.bytes, expected, 0.01 * expected);
  EXPECT_DOUBLE_EQ(two.exchange, two.bytes / 2 * (1 / kCopying + 1e-9));
}

TEST(ScaleModel, OfManyViewsUpdatesMoreButNotAll) {
  const Training small = LargeTraining(Example(), 1e6, 4), large = LargeTraining(Example(), 1e8, 4);
  EXPECT_DOUBLE_EQ(small.drawn, 2.5e5);
  EXPECT_DOUBLE_EQ(large.drawn, kMaxDrawn);
  EXPECT_GT(small.updated, small.drawn);
  EXPECT_LT(small.updated, 4 * small.drawn);
}

// Every 100 views: 25 steps of four.
TEST(ScaleModel, HandsGaussiansOverInDensityControl) {
  const Training t = LargeTraining(Example(), 1e6, 4);
  EXPECT_DOUBLE_EQ(t.assembled, 1e6 / 25 * (3 + 4 + 3 + 1 + 3 + 3));
  Training still = t;
  still.moved = 0;
  const Machine two{2, 1e9, 0};
  const double moved = TimeOf(Example(), t, two).bytes - TimeOf(Example(), still, two).bytes;
  EXPECT_NEAR(moved, 3 * 1e6 / 25 * 4 * (45 + 2 * 59) / 2, 1e3);
}

TEST(ScaleModel, ReadsTheStatisticsOfOneRank) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "stats.json";
  Json stats{{"gaussians", 1600},
             {"seconds", 2.0},
             {"cpu_seconds", 1.0},
             {"phases_ms",
              {{"project", 1},
               {"sort", 2},
               {"blend", 3},
               {"loss", 4},
               {"backward", 5},
               {"adam", 6},
               {"density", 7}}},
             {"batch",
              {{"ranks", 1},
               {"steps", 10},
               {"views", 40},
               {"groups_drawn", 1000},
               {"groups_updated", 500}}}};
  std::ofstream(path) << stats;
  const Measured m = MeasuredIn(path, 100);
  EXPECT_DOUBLE_EQ(m.batch, 4);
  EXPECT_DOUBLE_EQ(m.drawn, 0.25);
  EXPECT_DOUBLE_EQ(m.updated, 0.5);
  // What was measured comes out again: 28 ms a step, half of them on the processor.
  EXPECT_NEAR(TimeOf(m, TrainingOf(m), {}).total(), 0.014, 1e-9);
  stats["batch"]["ranks"] = 2;
  std::ofstream(path) << stats;
  test::ExpectError([&] { MeasuredIn(path, 100); }, {"stats.json", "batch.ranks"});
}

}  // namespace
}  // namespace cosplat::scale
