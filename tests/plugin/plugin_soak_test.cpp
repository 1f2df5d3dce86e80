// A minute and a half of live video with bad and late frames: nothing grows, nothing drifts. The
// two hours are cosplat_bench_plugin's.
#include "tests/plugin/plugin_fixture.h"
#include "tests/support/soak.h"

namespace cosplat::test {
namespace {

TEST(PluginSoak, NothingGrowsAndNothingDrifts) {
  const PluginFiles& files = PluginFiles::Get();
  Soak::Settings settings;
  settings.avatar_path = files.avatar_path;
  settings.flame_path = files.flame_path;
  settings.frames = 2600;  // a pause, and some after it
  settings.checkpoints = 26;
  settings.side = 48;
  const SoakReport report = Soak(files.flame, settings).Run();
  EXPECT_EQ(report.unexpected, 0);
  EXPECT_EQ(report.checkpoints, 26);
  EXPECT_EQ(report.unlike_replayed, 0);
  EXPECT_GT(report.plain, 20);
  EXPECT_EQ(report.unlike_plain, 0);
  EXPECT_GT(report.bad, 10u);
  EXPECT_GT(report.late, 100u);
  const cosplat_health& h = report.health;
  EXPECT_EQ(h.not_finite + h.out_of_range + h.wrong_size, report.bad);
  EXPECT_EQ(h.late, report.late);
  EXPECT_GT(h.decayed, 60u);
  EXPECT_EQ(h.returned, 1u);
  EXPECT_EQ(h.softened, 0u);
  EXPECT_EQ(h.accepted + h.held + h.decayed, 2600u) << "each advance is one of these";
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // No memory is asked for (plugin_allocation_test.cpp): what is left are pages of the first time.
  EXPECT_LT(report.last_mb - report.first_mb, 2);
#endif
}

}  // namespace
}  // namespace cosplat::test
