// The OBS source in OBS: what its canvas shows is what the library draws.
#include <util/platform.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/hosts/obs_fixture.h"
#include "tests/support/stand_in_webcam.h"

namespace cosplat::test {
namespace {

class ObsSource : public testing::Test {
 protected:
  static void SetUpTestSuite() { obs = new Obs; }
  static void TearDownTestSuite() {
    delete obs;
    obs = nullptr;
  }

  void SetUp() override {
    if (!obs->there_is()) GTEST_SKIP() << "Xvfb is not installed";
    scene_.reset(obs_scene_create("scene"));
    obs_set_output_source(0, obs_scene_get_source(scene_.get()));
    const SourcePointer backdrop(obs_source_create("backdrop", "backdrop", nullptr, nullptr),
                                 obs_source_release);
    obs_scene_add(scene_.get(), backdrop.get());
  }
  void TearDown() override {
    if (!obs->there_is()) return;
    obs_set_output_source(0, nullptr);
    obs_source_remove(obs_scene_get_source(scene_.get()));  // from OBS 31's canvas, which keeps it
  }

  static DataPointer Settings() {
    const PluginFiles& files = PluginFiles::Get();
    DataPointer settings(obs_data_create(), obs_data_release);
    obs_data_set_string(settings.get(), "avatar", files.avatar_path.c_str());
    obs_data_set_string(settings.get(), "flame", files.flame_path.c_str());
    obs_data_set_int(settings.get(), "width", kCanvas);
    obs_data_set_int(settings.get(), "height", kCanvas);
    return settings;
  }

  // Into the scene, above those before it.
  SourcePointer Add(const DataPointer& settings) {
    SourcePointer source(obs_source_create("cosplat_avatar", "avatar", settings.get(), nullptr),
                         obs_source_release);
    EXPECT_NE(source, nullptr);
    obs_scene_add(scene_.get(), source.get());
    return source;
  }

  static Obs* obs;
  ScenePointer scene_{nullptr, obs_scene_release};
};
Obs* ObsSource::obs = nullptr;

// Over the black backdrop.
Wanted OnBlack() {
  Wanted wanted{kCanvas, kCanvas};
  wanted.format = COSPLAT_FORMAT_BGRA8;
  wanted.alpha = COSPLAT_ALPHA_PREMULTIPLIED;
  return wanted;
}

TEST_F(ObsSource, ShowsTheLibrarysPictureAndFollowsItsSettings) {
  const SourcePointer source = Add(Settings());
  EXPECT_LE(obs->WaitFor(Draw(OnBlack())), 1);
  EXPECT_EQ(obs_source_get_width(source.get()), kCanvas);

  const DataPointer turned = Settings();
  obs_data_set_double(turned.get(), "azimuth", 40);
  obs_data_set_double(turned.get(), "zoom", 1.5);
  obs_data_set_string(turned.get(), "background", "color");
  obs_data_set_int(turned.get(), "background_color", 0xff3366cc);  // 0xAABBGGRR
  obs_source_update(source.get(), turned.get());
  Wanted wanted = OnBlack();
  wanted.azimuth = 40;
  wanted.zoom = 1.5f;
  wanted.alpha = COSPLAT_ALPHA_OPAQUE;
  wanted.background = {0xcc / 255.0f, 0x66 / 255.0f, 0x33 / 255.0f};
  EXPECT_LE(obs->WaitFor(Draw(wanted)), 1);
}

TEST_F(ObsSource, IsBlendedAsItsBytesAre) {
  const DataPointer below = Settings();
  obs_data_set_string(below.get(), "background", "avatar");
  obs_data_set_double(below.get(), "azimuth", 90);
  const SourcePointer back = Add(below), front = Add(Settings());
  Wanted wanted = OnBlack();
  std::vector<uint8_t> expected = Draw(wanted);
  wanted.azimuth = 90;
  wanted.alpha = COSPLAT_ALPHA_OPAQUE;
  const std::vector<uint8_t> behind = Draw(wanted);
  int partly = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const int alpha = expected[i / 4 * 4 + 3];
    if (i % 4 == 3) continue;
    partly += alpha > 20 && alpha < 235;
    expected[i] = uint8_t(expected[i] + (behind[i] * (255 - alpha) + 127) / 255);
  }
  EXPECT_GT(partly, 100);
  EXPECT_LE(obs->WaitFor(expected), 1);
}

TEST_F(ObsSource, ShowsADrivenFace) {
  // A face that stands still, so that it does not matter when it is looked at.
  const std::string drive = PluginFiles::Get().folder / "still.npz";
  Npz npz(drive);
  npz.Add("expr", {2, 2}, std::vector<float>{1, -0.5f, 1, -0.5f});
  npz.Add("jaw_rot", {2, 3}, std::vector<float>{0.2f, 0, 0, 0.2f, 0, 0});
  npz.Write(drive);
  const DataPointer settings = Settings();
  obs_data_set_string(settings.get(), "drive", drive.c_str());
  const SourcePointer source = Add(settings);
  const OpenAvatar avatar;
  cosplat_policy policy = Zeroed<cosplat_policy>();
  policy.loop = 1;
  ASSERT_EQ(cosplat_set_policy(avatar, &policy), COSPLAT_OK);
  ASSERT_EQ(cosplat_set_drive(avatar, drive.c_str()), COSPLAT_OK);
  for (int64_t n = 0; n < 50; ++n)  // until it has come in from rest
    ASSERT_EQ(cosplat_advance(avatar, n * 40'000'000), COSPLAT_OK);
  const std::vector<uint8_t> expected = Draw(avatar, OnBlack());
  EXPECT_NE(expected, Draw(OnBlack()));
  EXPECT_LE(obs->WaitFor(expected), 1);
}

TEST_F(ObsSource, ShowsTheFaceBeforeAWebcam) {
  const StandInWebcam webcam;
  const DataPointer settings = Settings();
  obs_data_set_string(settings.get(), "drive", "webcam:");
  const SourcePointer source = Add(settings);
  const OpenAvatar avatar;
  ASSERT_EQ(cosplat_set_drive(avatar, "webcam:"), COSPLAT_OK);
  for (int64_t n = 0; n < 50; ++n) {  // until it has come in from rest
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    ASSERT_EQ(cosplat_advance(avatar, n * 40'000'000), COSPLAT_OK);
  }
  const std::vector<uint8_t> expected = Draw(avatar, OnBlack());
  EXPECT_NE(expected, Draw(OnBlack()));
  EXPECT_LE(obs->WaitFor(expected), 1);
}

TEST_F(ObsSource, SaysWhatIsWrongAndRecovers) {
  const DataPointer wrong = Settings();
  obs_data_set_string(wrong.get(), "avatar", "/nowhere/a.glb");
  const SourcePointer source = Add(Settings());
  EXPECT_LE(obs->WaitFor(Draw(OnBlack())), 1);
  obs_source_update(source.get(), wrong.get());
  EXPECT_LE(obs->WaitFor(std::vector<uint8_t>(size_t(4) * kCanvas * kCanvas)), 1);
  cosplat_avatar* avatar = nullptr;
  const cosplat_open_options options = OpenOptions();
  ASSERT_NE(cosplat_open("/nowhere/a.glb", &options, &avatar), COSPLAT_OK);
  const std::string problem = cosplat_last_error(nullptr);
  EXPECT_TRUE(WasLogged("[cosplat] " + problem));
  obs_properties_t* properties = obs_source_properties(source.get());
  EXPECT_EQ(obs_property_description(obs_properties_get(properties, "status")), problem);
  obs_properties_destroy(properties);
  obs_source_update(source.get(), Settings().get());
  EXPECT_LE(obs->WaitFor(Draw(OnBlack())), 1);
}

TEST_F(ObsSource, SaysThatTheHeadWasNotFilmedFromThere) {
  AvatarModel filmed = PluginFiles::Get().avatar;
  filmed.filmed = FilmedFrom{{-0.1f, 0.3f}, {-0.2f, 0.2f}, {}};
  const DataPointer settings = Settings();
  obs_data_set_string(
      settings.get(), "avatar", PluginFiles::Get().Write("filmed.glb", filmed).c_str());
  const SourcePointer source = Add(settings);
  const auto status = [&] {
    obs_properties_t* properties = obs_source_properties(source.get());
    obs_property_t* line = obs_properties_get(properties, "status");
    const std::string text = line ? obs_property_description(line) : "";
    obs_properties_destroy(properties);
    return text;
  };
  EXPECT_LE(obs->WaitFor(Draw(OnBlack())), 1);
  EXPECT_EQ(status(), "");
  obs_data_set_double(settings.get(), "azimuth", 90);
  obs_source_update(source.get(), settings.get());
  Wanted aside = OnBlack();
  aside.azimuth = 90;
  EXPECT_LE(obs->WaitFor(Draw(aside)), 1);
  EXPECT_NE(status().find("filmed from -6 to 17 degrees to its left, and from -11 to 11 upwards"),
            std::string::npos)
      << status();
}

TEST_F(ObsSource, OfAnotherSizeIsAsLargeOnTheCanvas) {
  const DataPointer settings = Settings();
  const SourcePointer source = Add(settings);
  EXPECT_LE(obs->WaitFor(Draw(OnBlack())), 1);
  constexpr uint32_t kWidth = 100, kHeight = 60;
  obs_data_set_int(settings.get(), "width", kWidth);
  obs_data_set_int(settings.get(), "height", kHeight);
  obs_data_set_double(settings.get(), "elevation", -20);
  obs_source_update(source.get(), settings.get());
  Wanted wanted = OnBlack();
  wanted.width = kWidth;
  wanted.height = kHeight;
  wanted.elevation = -20;
  const std::vector<uint8_t> picture = Draw(wanted);
  std::vector<uint8_t> expected(size_t(4) * kCanvas * kCanvas);  // at the top left
  for (size_t y = 0; y < kHeight; ++y)
    std::copy_n(&picture[4 * kWidth * y], 4 * kWidth, &expected[4 * kCanvas * y]);
  EXPECT_LE(obs->WaitFor(expected), 1);
  EXPECT_EQ(obs_source_get_width(source.get()), kWidth);
  EXPECT_EQ(obs_source_get_height(source.get()), kHeight);
}

TEST_F(ObsSource, DoesNothingBeforeItIsShown) {
  const DataPointer wrong = Settings();
  obs_data_set_string(wrong.get(), "avatar", "/nowhere/unseen.glb");
  SourcePointer source(obs_source_create("cosplat_avatar", "unseen", wrong.get(), nullptr),
                       obs_source_release);
  os_sleep_ms(200);
  const auto logged = [] { return WasLogged("unseen.glb"); };
  EXPECT_FALSE(logged());
  obs_scene_add(scene_.get(), source.get());
  for (int tries = 0; tries < 200 && !logged(); ++tries) os_sleep_ms(50);
  EXPECT_TRUE(logged());
}

TEST_F(ObsSource, EverySettingHasWordsAndADefault) {
  obs_properties_t* properties = obs_get_source_properties("cosplat_avatar");
  ASSERT_NE(properties, nullptr);
  int count = 0;
  for (obs_property_t* p = obs_properties_first(properties); p; obs_property_next(&p), ++count)
    EXPECT_STRNE(obs_property_description(p), obs_property_name(p));
  EXPECT_EQ(count, 12);
  obs_properties_destroy(properties);
  const DataPointer defaults(obs_get_source_defaults("cosplat_avatar"), obs_data_release);
  EXPECT_STREQ(obs_data_get_string(defaults.get(), "background"), "transparent");
  EXPECT_EQ(obs_data_get_double(defaults.get(), "fps"), 30);
}

}  // namespace
}  // namespace cosplat::test
