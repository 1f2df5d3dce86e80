// cosplat.h: drives, time and the rule for bad frames, as a host sees them.
#include <cmath>
#include <limits>

#include "avatar/live/udp_socket.h"
#include "avatar/live/vmc_frame.h"
#include "tests/avatar/live/osc_builder.h"
#include "tests/plugin/plugin_fixture.h"
#include "tests/plugin/restless_sequence.h"
#include "tests/support/restless_params.h"

namespace cosplat::test {
namespace {

constexpr uint32_t kSide = 48;
constexpr int64_t kMillisecond = 1'000'000;

using Bytes = std::vector<uint8_t>;

Bytes Render(cosplat_avatar* avatar) {
  Bytes bytes;
  const cosplat_picture picture = PictureInto(bytes, kSide, kSide);
  EXPECT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK) << cosplat_last_error(avatar);
  return bytes;
}

Bytes RenderAt(cosplat_avatar* avatar, int64_t milliseconds) {
  EXPECT_EQ(cosplat_advance(avatar, milliseconds * kMillisecond), COSPLAT_OK)
      << cosplat_last_error(avatar);
  return Render(avatar);
}

cosplat_status Set(cosplat_avatar* avatar, int motion, int64_t milliseconds) {
  const FlameParams params = RestlessParams(PluginFiles::Get().flame, motion);
  const cosplat_parameters set = ParametersOf(params, milliseconds * kMillisecond);
  return cosplat_set_parameters(avatar, &set);
}

cosplat_health HealthOf(cosplat_avatar* avatar) {
  cosplat_health health = Zeroed<cosplat_health>();
  EXPECT_EQ(cosplat_get_health(avatar, &health), COSPLAT_OK);
  return health;
}

Bytes Still(int motion) {
  const OpenAvatar avatar;
  EXPECT_EQ(Set(avatar, motion, 0), COSPLAT_OK);
  return Render(avatar);
}
Bytes Resting() {
  const OpenAvatar avatar;
  return Render(avatar);
}

TEST(PluginLive, WithoutTimeWhatIsSetIsDrawn) {
  const OpenAvatar avatar;
  for (const int motion : {1, 2, 1}) {
    ASSERT_EQ(Set(avatar, motion, 0), COSPLAT_OK);
    EXPECT_EQ(Render(avatar), Still(motion));
  }
  const cosplat_health health = HealthOf(avatar);
  EXPECT_EQ(health.face, uint32_t(COSPLAT_FACE_REST));
  EXPECT_EQ(health.age_s, -1);
  EXPECT_EQ(health.accepted, 0u);
}

TEST(PluginLive, HoldsDecaysAndReturns) {
  const OpenAvatar avatar;
  ASSERT_EQ(Set(avatar, 1, 1000), COSPLAT_OK);
  EXPECT_EQ(RenderAt(avatar, 1000), Still(1));
  ASSERT_EQ(Set(avatar, 2, 1040), COSPLAT_OK);
  EXPECT_EQ(Render(avatar), Still(1)) << "before time moves on";
  EXPECT_EQ(RenderAt(avatar, 1040), Still(2));
  EXPECT_EQ(HealthOf(avatar).face, uint32_t(COSPLAT_FACE_LIVE));
  EXPECT_EQ(RenderAt(avatar, 1290), Still(2)) << "held";
  const Bytes midway = RenderAt(avatar, 1700);
  EXPECT_NE(midway, Still(2));
  EXPECT_NE(midway, Resting());
  EXPECT_EQ(HealthOf(avatar).face, uint32_t(COSPLAT_FACE_DECAYING));
  EXPECT_EQ(RenderAt(avatar, 2290), Resting());
  EXPECT_EQ(HealthOf(avatar).face, uint32_t(COSPLAT_FACE_REST));
  EXPECT_NEAR(HealthOf(avatar).age_s, 1.25f, 1e-6f);
  ASSERT_EQ(Set(avatar, 3, 2500), COSPLAT_OK);
  EXPECT_EQ(RenderAt(avatar, 2500), Resting()) << "not cut to";
  EXPECT_EQ(HealthOf(avatar).face, uint32_t(COSPLAT_FACE_RETURNING));
  EXPECT_NE(RenderAt(avatar, 2600), Resting());
  EXPECT_EQ(RenderAt(avatar, 2700), Still(3));
  const cosplat_health health = HealthOf(avatar);
  EXPECT_EQ(health.face, uint32_t(COSPLAT_FACE_LIVE));
  EXPECT_EQ(health.accepted, 3u);
  EXPECT_EQ(health.returned, 1u);
  EXPECT_EQ(health.held, 3u);     // at 1290, 2600 and 2700
  EXPECT_EQ(health.decayed, 2u);  // at 1700 and 2290
}

TEST(PluginLive, BadFramesAreCountedAndTheLastGoodOneStays) {
  const OpenAvatar avatar;
  ASSERT_EQ(Set(avatar, 1, 1000), COSPLAT_OK);
  const Bytes good = RenderAt(avatar, 1000);
  FlameParams params = RestlessParams(PluginFiles::Get().flame, 2);
  const auto refused = [&](cosplat_status status, int64_t milliseconds) {
    const cosplat_parameters set = ParametersOf(params, milliseconds * kMillisecond);
    EXPECT_EQ(cosplat_set_parameters(avatar, &set), status);
  };
  refused(COSPLAT_ERROR_LATE, 999);
  params.pose[2][0] = std::numeric_limits<float>::quiet_NaN();
  refused(COSPLAT_ERROR_NOT_FINITE, 1010);
  params.pose[2][0] = COSPLAT_LARGEST_PARAMETER + 1;
  refused(COSPLAT_ERROR_ARGUMENT, 1020);
  EXPECT_EQ(cosplat_set_expression(avatar, 0, INFINITY, 1030 * kMillisecond),
            COSPLAT_ERROR_NOT_FINITE);
  EXPECT_EQ(cosplat_set_joint(avatar, 1, nullptr, 1030 * kMillisecond), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_set_expression(avatar, 10000, 0, 1030 * kMillisecond), COSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(RenderAt(avatar, 1040), good);
  const cosplat_health health = HealthOf(avatar);
  EXPECT_EQ(health.accepted, 1u);
  EXPECT_EQ(health.late, 1u);
  EXPECT_EQ(health.not_finite, 2u);
  EXPECT_EQ(health.out_of_range, 1u);
  EXPECT_EQ(health.wrong_size, 1u);
}

TEST(PluginLive, ResetGoesBackToWhatIsSet) {
  const OpenAvatar avatar;
  ASSERT_EQ(Set(avatar, 1, 1000), COSPLAT_OK);
  RenderAt(avatar, 1000);
  EXPECT_EQ(cosplat_advance(avatar, 999 * kMillisecond), COSPLAT_ERROR_LATE);
  EXPECT_EQ(RenderAt(avatar, 1000), Still(1));
  ASSERT_EQ(cosplat_reset_parameters(avatar), COSPLAT_OK);
  EXPECT_EQ(Render(avatar), Resting());
  ASSERT_EQ(Set(avatar, 2, 5), COSPLAT_OK);
  EXPECT_EQ(Render(avatar), Still(2));
  EXPECT_EQ(RenderAt(avatar, 5), Still(2));
}

TEST(PluginLive, ARecordingDrives) {
  const std::string path = WriteSequence("drive.npz", 8);
  const OpenAvatar avatar;
  ASSERT_EQ(cosplat_set_drive(avatar, path.c_str()), COSPLAT_OK) << cosplat_last_error(avatar);
  std::vector<Bytes> pictures;
  for (int f = 0; f < 8; ++f) pictures.push_back(RenderAt(avatar, 5000 + 100 * f));
  for (size_t f = 1; f < 8; ++f) EXPECT_NE(pictures[f], pictures[f - 1]) << f;
  cosplat_health health = HealthOf(avatar);
  EXPECT_EQ(health.accepted, 8u);
  EXPECT_EQ(health.drive_frames, 8u);
  EXPECT_EQ(health.drive_ended, 1u);
  EXPECT_STREQ(health.drive, "recorded sequence drive.npz, 8 frames at 10 per second");
  EXPECT_STREQ(health.drive_problem, "");
  EXPECT_EQ(RenderAt(avatar, 9000), Resting()) << "its end is one";
  // Set again it begins anew, and by another clock.
  ASSERT_EQ(cosplat_reset_parameters(avatar), COSPLAT_OK);
  ASSERT_EQ(cosplat_set_drive(avatar, path.c_str()), COSPLAT_OK);
  for (size_t f = 0; f < 8; ++f) EXPECT_EQ(RenderAt(avatar, 100 * int64_t(f)), pictures[f]) << f;
  ASSERT_EQ(cosplat_set_drive(avatar, nullptr), COSPLAT_OK);
  health = HealthOf(avatar);
  EXPECT_EQ(health.drive_frames, 0u);
  EXPECT_STREQ(health.drive, "");
}

// What a VMC drive makes of jawOpen at 0.5: the jaw's turn about x, and which map it says it used.
float JawByVmc(const std::string& avatar_path, std::string& map) {
  const OpenAvatar avatar(avatar_path);
  EXPECT_EQ(cosplat_set_drive(avatar, "vmc://:0"), COSPLAT_OK) << cosplat_last_error(avatar);
  const std::string drive = HealthOf(avatar).drive;
  map = drive.substr(drive.find(", by ") + 5);
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(drive.substr(0, drive.find(','))));
  EXPECT_TRUE(sender.Send(WriteVmcFrame({{"jawOpen", 0.5f}})));
  EXPECT_EQ(cosplat_advance(avatar, 0), COSPLAT_OK);
  cosplat_parameters parameters = Zeroed<cosplat_parameters>();
  EXPECT_EQ(cosplat_get_parameters(avatar, &parameters), COSPLAT_OK);
  return parameters.joints[2][0];
}

TEST(PluginLive, BlendshapesMoveAnAvatarByItsOwnMapOrTheGeneralOne) {
  const PluginFiles& files = PluginFiles::Get();
  std::string map;
  EXPECT_FLOAT_EQ(JawByVmc(files.avatar_path, map), 0.25f);
  EXPECT_EQ(map, "the general blendshape map: jaw and gaze only");
  AvatarModel avatar = files.avatar;
  BlendshapeMap& own = avatar.blendshapes.emplace(GeneralBlendshapeMap(&files.flame));
  for (float& x : own.matrix) x *= 0.5f;
  EXPECT_FLOAT_EQ(JawByVmc(files.Write("with_map.glb", avatar), map), 0.125f);
  EXPECT_EQ(map, "the avatar's own blendshape map");
}

TEST(PluginLive, WhatArrivesAndIsNotUsedIsInTheHealth) {
  const OpenAvatar avatar;
  ASSERT_EQ(cosplat_set_drive(avatar, "vmc://:0"), COSPLAT_OK);
  EXPECT_EQ(HealthOf(avatar).drive_packets, 0u);
  EXPECT_STREQ(HealthOf(avatar).drive_notes, "");
  const std::string drive = HealthOf(avatar).drive;
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(drive.substr(0, drive.find(','))));
  for (int i = 0; i < 27; ++i) ASSERT_TRUE(sender.Send(VmcValue("Joy", 1)));
  ASSERT_EQ(cosplat_advance(avatar, 0), COSPLAT_OK);
  const cosplat_health health = HealthOf(avatar);
  EXPECT_EQ(health.drive_packets, 27u);
  EXPECT_EQ(health.drive_unusable, 27u);
  EXPECT_EQ(health.drive_frames, 0u);
  EXPECT_STREQ(health.drive_notes, "ignored blendshapes: Joy (27)");
}

// Of cosplat.h 0.2.
struct Health02 {
  uint32_t struct_size, face;
  float age_s;
  uint32_t drive_ended;
  uint64_t accepted, replaced, late, not_finite, out_of_range, wrong_size, softened, held, decayed;
  uint64_t returned, drive_frames, drive_replaced, drive_reordered, drive_malformed, drive_oversize;
  uint64_t drive_flooded;
  const char *drive, *drive_problem;
};
template <class A, class B, class T>
bool SamePlace(T A::*a, T B::*b) {
  const A x{};
  const B y{};
  return reinterpret_cast<const char*>(&(x.*a)) - reinterpret_cast<const char*>(&x) ==
         reinterpret_cast<const char*>(&(y.*b)) - reinterpret_cast<const char*>(&y);
}

TEST(PluginLive, TheHealthBeginsWithAllFieldsOf02) {
#define SAME(field) EXPECT_TRUE(SamePlace(&Health02::field, &cosplat_health::field)) << #field
  SAME(struct_size);
  SAME(face);
  SAME(age_s);
  SAME(drive_ended);
  SAME(accepted);
  SAME(replaced);
  SAME(late);
  SAME(not_finite);
  SAME(out_of_range);
  SAME(wrong_size);
  SAME(softened);
  SAME(held);
  SAME(decayed);
  SAME(returned);
  SAME(drive_frames);
  SAME(drive_replaced);
  SAME(drive_reordered);
  SAME(drive_malformed);
  SAME(drive_oversize);
  SAME(drive_flooded);
  SAME(drive);
  SAME(drive_problem);
#undef SAME
}

TEST(PluginLive, AnOlderHostsHealthIsWrittenAsFarAsItGoes) {
  const OpenAvatar avatar;
  constexpr size_t kOld = sizeof(Health02);
  struct {
    cosplat_health health;
    char after[8];
  } host;
  std::memset(&host, 0x5a, sizeof(host));
  host.health.struct_size = kOld;
  ASSERT_EQ(cosplat_get_health(avatar, &host.health), COSPLAT_OK);
  EXPECT_EQ(host.health.struct_size, kOld);
  EXPECT_STREQ(host.health.drive_problem, "");
  const auto* bytes = reinterpret_cast<const unsigned char*>(&host);
  for (size_t i = kOld; i < sizeof(host); ++i) EXPECT_EQ(bytes[i], 0x5a) << i;
  host.health.struct_size = kOld - 1;
  EXPECT_EQ(cosplat_get_health(avatar, &host.health), COSPLAT_ERROR_ARGUMENT);
}

TEST(PluginLive, ADriveThatCannotBeOpenedIsNamed) {
  const std::string path = WriteSequence("good.npz", 3);
  const OpenAvatar avatar;
  ASSERT_EQ(cosplat_set_drive(avatar, path.c_str()), COSPLAT_OK);
  for (const char* drive : {"", "/nowhere/talk.npz", "udp://nonsense:port", "vmc://", "ftp://a"}) {
    EXPECT_EQ(cosplat_set_drive(avatar, drive), COSPLAT_ERROR_DRIVE) << drive;
    const std::string error = cosplat_last_error(avatar);
    EXPECT_NE(error.find(drive), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  EXPECT_NE(std::string(HealthOf(avatar).drive).find("good.npz"), std::string::npos);
}

TEST(PluginLive, PoliciesAreCheckedAndFollowed) {
  const OpenAvatar avatar;
  const auto refused = [&](const auto& spoil) {
    cosplat_policy policy = Zeroed<cosplat_policy>();
    spoil(policy);
    EXPECT_EQ(cosplat_set_policy(avatar, &policy), COSPLAT_ERROR_ARGUMENT);
  };
  for (const float x : {-1.0f, 1e-7f, 1e7f, NAN, INFINITY}) {
    refused([&](auto& p) { p.hold_s = x; });
    refused([&](auto& p) { p.decay_s = x; });
    refused([&](auto& p) { p.blend_in_s = x; });
    refused([&](auto& p) { p.min_cutoff_hz = x; });
    refused([&](auto& p) { p.frames_per_second = x; });
  }
  for (const float x : {-1.0f, 1e7f, NAN}) refused([&](auto& p) { p.beta = x; });
  refused([](auto& p) { p.range = 2; });
  refused([](auto& p) { p.smoothing = 2; });
  refused([](auto& p) { p.loop = 2; });
  EXPECT_EQ(cosplat_set_policy(avatar, nullptr), COSPLAT_ERROR_ARGUMENT);

  cosplat_policy policy = Zeroed<cosplat_policy>();
  policy.hold_s = 3;
  policy.decay_s = 0.5f;
  policy.blend_in_s = 1e-6f;
  ASSERT_EQ(cosplat_set_policy(avatar, &policy), COSPLAT_OK);
  ASSERT_EQ(Set(avatar, 1, 0), COSPLAT_OK);
  RenderAt(avatar, 0);
  EXPECT_EQ(RenderAt(avatar, 3000), Still(1));
  EXPECT_EQ(RenderAt(avatar, 3500), Resting());
  ASSERT_EQ(Set(avatar, 2, 3600), COSPLAT_OK);
  RenderAt(avatar, 3600);
  EXPECT_EQ(RenderAt(avatar, 3601), Still(2));
}

TEST(PluginLive, WhatTrainingNeverSawIsBroughtBackUnlessTheHostWantsIt) {
  FlameParams wild;
  wild.expression = {20};
  const cosplat_parameters set = ParametersOf(wild);
  const OpenAvatar plain, soft, free;
  cosplat_policy policy = Zeroed<cosplat_policy>();
  policy.range = COSPLAT_RANGE_FREE;
  ASSERT_EQ(cosplat_set_policy(free, &policy), COSPLAT_OK);
  for (cosplat_avatar* avatar :
       {(cosplat_avatar*)plain, (cosplat_avatar*)soft, (cosplat_avatar*)free})
    ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
  EXPECT_EQ(RenderAt(free, 0), Render(plain));
  EXPECT_NE(RenderAt(soft, 0), Render(plain));
  EXPECT_EQ(HealthOf(free).softened, 0u);
  EXPECT_EQ(HealthOf(soft).softened, 1u);
}

}  // namespace
}  // namespace cosplat::test
