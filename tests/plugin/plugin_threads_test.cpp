// cosplat.h from many threads: handles are independent, one handle is one thread's at a time.
#include <atomic>
#include <thread>

#include "tests/plugin/plugin_fixture.h"
#include "tests/plugin/restless_sequence.h"
#include "tests/support/live_story.h"
#include "tests/support/restless_params.h"

namespace cosplat::test {
namespace {

constexpr int kFrames = 12;

std::vector<uint8_t> RenderFrame(cosplat_avatar* avatar, int motion, int frame) {
  const FlameParams params = RestlessParams(PluginFiles::Get().flame, motion + frame);
  const cosplat_parameters set = ParametersOf(params, frame);
  EXPECT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
  const auto side = uint32_t(40 + motion % 7);
  SetOrbit(avatar, side, side, 0.1f * float(motion + frame));
  std::vector<uint8_t> bytes;
  const cosplat_picture picture = PictureInto(bytes, side, side);
  EXPECT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK);
  return bytes;
}

using Film = std::vector<std::vector<uint8_t>>;

// Opens, plays and closes an avatar.
Film Play(int motion) {
  const OpenAvatar avatar;
  Film film;
  for (int f = 0; f < kFrames; ++f) film.push_back(RenderFrame(avatar, motion, f));
  return film;
}

TEST(PluginThreads, AvatarsBesideEachOtherAreAsOneAfterTheOther) {
  constexpr int kAvatars = 4;
  std::vector<Film> alone, beside(kAvatars);
  for (int a = 0; a < kAvatars; ++a) alone.push_back(Play(10 * a));
  std::vector<std::thread> threads;
  for (int a = 0; a < kAvatars; ++a)
    threads.emplace_back([&, a] { beside[size_t(a)] = Play(10 * a); });
  for (std::thread& thread : threads) thread.join();
  for (int a = 0; a < kAvatars; ++a) EXPECT_EQ(beside[size_t(a)], alone[size_t(a)]) << a;
}

// Bad and late frames, a drive besides, and time.
Film PlayLive(const std::string& drive) {
  const OpenAvatar avatar;
  EXPECT_EQ(cosplat_set_drive(avatar, drive.c_str()), COSPLAT_OK);
  LiveStory story(PluginFiles::Get().flame);
  Film film;
  for (int f = 0; f < 5 * kFrames; ++f) {
    story.Feed(avatar, f);
    EXPECT_EQ(cosplat_advance(avatar, f * LiveStory::kStepNs), COSPLAT_OK);
    cosplat_health health = Zeroed<cosplat_health>();
    EXPECT_EQ(cosplat_get_health(avatar, &health), COSPLAT_OK);
    std::vector<uint8_t> bytes;
    const cosplat_picture picture = PictureInto(bytes, 40, 40);
    EXPECT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK);
    film.push_back(bytes);
  }
  return film;
}

TEST(PluginThreads, LiveAvatarsBesideEachOtherAreAsOneAfterTheOther) {
  const std::string drive = WriteSequence("beside.npz", 4);
  const Film alone = PlayLive(drive);
  std::vector<Film> beside(4);
  std::vector<std::thread> threads;
  for (Film& film : beside) threads.emplace_back([&] { film = PlayLive(drive); });
  for (std::thread& thread : threads) thread.join();
  for (const Film& film : beside) EXPECT_EQ(film, alone);
}

TEST(PluginThreads, AvatarsInTurnDoNotSeeEachOther) {
  const Film first = Play(3), second = Play(7);
  const OpenAvatar a, b;
  for (int f = 0; f < kFrames; ++f) {
    EXPECT_EQ(RenderFrame(a, 3, f), first[size_t(f)]) << f;
    EXPECT_EQ(RenderFrame(b, 7, f), second[size_t(f)]) << f;
  }
}

TEST(PluginThreads, AHandleMayGoFromThreadToThread) {
  const Film expected = Play(5);
  const OpenAvatar avatar;
  for (int f = 0; f < kFrames; ++f)
    std::thread([&] { EXPECT_EQ(RenderFrame(avatar, 5, f), expected[size_t(f)]); }).join();
}

TEST(PluginThreads, AHandleInUseIsBusy) {
  const OpenAvatar avatar;
  constexpr uint32_t kSide = 64;
  std::atomic<int> drawn = 0, busy = 0;
  // Each thread draws into memory of its own and changes the parameters; those who come while
  // another is at it are turned away.
  const auto insist = [&](int motion) {
    const FlameParams params = RestlessParams(PluginFiles::Get().flame, motion);
    const cosplat_parameters set = ParametersOf(params);
    std::vector<uint8_t> bytes;
    const cosplat_picture picture = PictureInto(bytes, kSide, kSide);
    for (int i = 0; i < 1000000 && (busy < 10 || drawn < 10); ++i)
      for (const cosplat_status status :
           {cosplat_set_parameters(avatar, &set), cosplat_render(avatar, &picture)}) {
        if (status == COSPLAT_ERROR_BUSY) {
          ++busy;
          std::this_thread::yield();
        } else {
          EXPECT_EQ(status, COSPLAT_OK);
          ++drawn;
        }
      }
  };
  std::thread other(insist, 1);
  insist(2);
  other.join();
  EXPECT_GE(drawn, 10);
  EXPECT_GE(busy, 10);
}

TEST(PluginThreads, ClosingLetsTheOthersCallFinish) {
  for (int repeat = 0; repeat < 5; ++repeat) {
    cosplat_avatar* avatar = nullptr;
    const cosplat_open_options options = OpenOptions();
    ASSERT_EQ(cosplat_open(PluginFiles::Get().avatar_path.c_str(), &options, &avatar), COSPLAT_OK);
    std::atomic<int> drawn = 0;
    std::thread other([&] {
      std::vector<uint8_t> bytes;
      const cosplat_picture picture = PictureInto(bytes, 200, 200);
      cosplat_status status;
      while ((status = cosplat_render(avatar, &picture)) == COSPLAT_OK) {
        ++drawn;
        cosplat_reset_parameters(avatar);
      }
      EXPECT_EQ(status, COSPLAT_ERROR_HANDLE);
    });
    while (drawn < 1) std::this_thread::yield();
    EXPECT_EQ(cosplat_close(avatar), COSPLAT_OK);
    other.join();
  }
}

}  // namespace
}  // namespace cosplat::test
