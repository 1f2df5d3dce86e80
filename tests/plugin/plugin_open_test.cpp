// cosplat.h: opening, closing, what an avatar is, handles and texts.
#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/plugin/plugin_fixture.h"

namespace cosplat::test {
namespace {

bool Contains(const char* text, const std::string& part) {
  return std::string(text).find(part) != std::string::npos;
}

// What cosplat_open returns; closes what it opened.
cosplat_status Open(const char* path, const cosplat_open_options* options) {
  cosplat_avatar* avatar = nullptr;
  const cosplat_status status = cosplat_open(path, options, &avatar);
  EXPECT_EQ(avatar != nullptr, status == COSPLAT_OK);
  EXPECT_EQ(cosplat_close(avatar), COSPLAT_OK);
  return status;
}
const char* Path() { return PluginFiles::Get().avatar_path.c_str(); }

TEST(PluginVersion, IsTheProjects) {
  EXPECT_EQ(cosplat_version(), COSPLAT_VERSION);
  EXPECT_STREQ(cosplat_version_text(), COSPLAT_PROJECT_VERSION);
  EXPECT_LT(COSPLAT_MAKE_VERSION(0, 1, 9), COSPLAT_MAKE_VERSION(0, 2, 0));
}

TEST(PluginStatus, EachHasAText) {
  for (cosplat_status s = COSPLAT_OK; s <= COSPLAT_ERROR_DRIVE; ++s)
    EXPECT_STRNE(cosplat_status_text(s), "unknown status") << s;
  for (const cosplat_status s : {-1, COSPLAT_ERROR_DRIVE + 1, 1000000})
    EXPECT_STREQ(cosplat_status_text(s), "unknown status");
  EXPECT_STREQ(cosplat_status_text(COSPLAT_ERROR_INTERNAL), "internal fault");
}

TEST(PluginOpen, SaysWhatTheAvatarIs) {
  const PluginFiles& files = PluginFiles::Get();
  const OpenAvatar avatar;
  cosplat_info info = Zeroed<cosplat_info>();
  ASSERT_EQ(cosplat_get_info(avatar, &info), COSPLAT_OK);
  EXPECT_EQ(info.gaussian_count, 1500u);
  EXPECT_EQ(info.triangle_count, files.flame.faces.size());
  EXPECT_EQ(info.expression_count, uint32_t(kExpressionCount));
  EXPECT_EQ(info.joint_count, uint32_t(COSPLAT_JOINT_COUNT));
  const Gaussians rest = RestPose(files.avatar);
  for (int k = 0; k < 3; ++k) {
    float min = INFINITY, max = -INFINITY;
    for (size_t i = 0; i < rest.size(); ++i) {
      min = std::min(min, rest.at(kPosition, i)[k]);
      max = std::max(max, rest.at(kPosition, i)[k]);
    }
    EXPECT_NEAR(info.box_min[k], min, 1e-5f);
    EXPECT_NEAR(info.box_max[k], max, 1e-5f);
    EXPECT_EQ(info.background[k], files.avatar.background[size_t(k)]);
  }
}

TEST(PluginOpen, NamesExpressionsAndJoints) {
  const OpenAvatar avatar;
  const char* name = nullptr;
  uint32_t index = 99;
  for (uint32_t i = 0; i < uint32_t(kExpressionCount); ++i) {
    ASSERT_EQ(cosplat_expression_name(avatar, i, &name), COSPLAT_OK);
    EXPECT_EQ(name, "expression_" + std::to_string(i));
    ASSERT_EQ(cosplat_find_expression(avatar, name, &index), COSPLAT_OK);
    EXPECT_EQ(index, i);
  }
  const char* const joints[] = {"root", "neck", "jaw", "left_eye", "right_eye"};
  for (uint32_t j = 0; j < COSPLAT_JOINT_COUNT; ++j) {
    ASSERT_EQ(cosplat_joint_name(avatar, j, &name), COSPLAT_OK);
    EXPECT_STREQ(name, joints[j]);
    ASSERT_EQ(cosplat_find_joint(avatar, name, &index), COSPLAT_OK);
    EXPECT_EQ(index, j);
  }
  EXPECT_EQ(cosplat_expression_name(avatar, kExpressionCount, &name), COSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(cosplat_joint_name(avatar, COSPLAT_JOINT_COUNT, &name), COSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(cosplat_joint_name(avatar, 0, nullptr), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_expression_name(avatar, 0, nullptr), COSPLAT_ERROR_ARGUMENT);
  for (const char* wrong : {"", "jaws", "Jaw", "expression_", "expression_999"}) {
    index = 99;
    EXPECT_EQ(cosplat_find_joint(avatar, wrong, &index), COSPLAT_ERROR_NOT_FOUND);
    EXPECT_EQ(cosplat_find_expression(avatar, wrong, &index), COSPLAT_ERROR_NOT_FOUND);
    EXPECT_EQ(index, 99u);
  }
  EXPECT_EQ(cosplat_find_joint(avatar, nullptr, &index), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_find_joint(avatar, "jaw", nullptr), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_find_expression(avatar, nullptr, &index), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_find_expression(avatar, "expression_0", nullptr), COSPLAT_ERROR_ARGUMENT);
}

TEST(PluginOpen, RefusesBadFiles) {
  const PluginFiles& files = PluginFiles::Get();
  cosplat_open_options options = OpenOptions();
  EXPECT_EQ(Open("/nowhere/avatar.glb", &options), COSPLAT_ERROR_FILE);
  EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "/nowhere/avatar.glb"));
  EXPECT_EQ(Open("", &options), COSPLAT_ERROR_FILE);
  EXPECT_EQ(Open(files.folder.path().c_str(), &options), COSPLAT_ERROR_FILE);
  EXPECT_EQ(Open(files.flame_path.c_str(), &options), COSPLAT_ERROR_FILE);
  const std::string cut = files.folder / "cut.glb";
  std::ofstream(cut) << "glTF";
  EXPECT_EQ(Open(cut.c_str(), &options), COSPLAT_ERROR_FILE);
}

TEST(PluginOpen, RefusesWithoutItsFlameModel) {
  const PluginFiles& files = PluginFiles::Get();
  cosplat_open_options options = OpenOptions();
  for (const char* none : {static_cast<const char*>(nullptr), ""}) {
    options.flame_path = none;
    EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_FLAME);
    EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "head.npz"));
    EXPECT_TRUE(Contains(cosplat_last_error(nullptr), files.flame.sha256));
  }
  options.flame_path = "/nowhere/flame.pkl";
  EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_FLAME);
  EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "/nowhere/flame.pkl"));
  FlameModel other = files.flame;
  other.template_vertices[0] += 1e-3f;
  const std::string path = files.folder / "other.npz";
  WriteFlameModelNpz(path, other);
  options.flame_path = path.c_str();
  EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_FLAME);
}

TEST(PluginOpen, TakesTheModelFromTheAvatarsFile) {
  const PluginFiles& files = PluginFiles::Get();
  AvatarModel avatar = files.avatar;
  avatar.flame_file = files.flame.file;
  const std::string path = files.Write("whole.glb", avatar);
  cosplat_open_options options = OpenOptions();
  EXPECT_EQ(Open(path.c_str(), &options), COSPLAT_OK) << "the same model by its path";
  options.flame_path = nullptr;
  EXPECT_EQ(Open(path.c_str(), &options), COSPLAT_OK) << cosplat_last_error(nullptr);
  // What is no model, or not this avatar's.
  avatar.flame_file.resize(1000);
  EXPECT_EQ(Open(files.Write("cut.glb", avatar).c_str(), &options), COSPLAT_ERROR_FLAME);
  EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "cut.glb/flame.npz"));
  FlameModel other = files.flame;
  other.template_vertices[0] += 1e-3f;
  WriteFlameModelNpz(files.folder / "another.npz", other);
  avatar.flame_file = LoadFlameModel(files.folder / "another.npz").file;
  EXPECT_EQ(Open(files.Write("mixed.glb", avatar).c_str(), &options), COSPLAT_ERROR_FLAME);
  EXPECT_TRUE(Contains(cosplat_last_error(nullptr), files.flame.sha256));
}

TEST(PluginOpen, RefusesWrongArguments) {
  cosplat_open_options options = OpenOptions();
  EXPECT_EQ(Open(nullptr, &options), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(Open(Path(), nullptr), COSPLAT_ERROR_ARGUMENT);
  EXPECT_EQ(cosplat_open(Path(), &options, nullptr), COSPLAT_ERROR_ARGUMENT);
  // The first version's had no `bust`.
  const uint32_t first = offsetof(cosplat_open_options, bust);
  for (const uint32_t size : {0u, 4u, first - 1, 100000u, ~0u}) {
    options.struct_size = size;
    EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_ARGUMENT);
    EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "struct_size: " + std::to_string(size)));
  }
  options.struct_size = first;
  options.bust = 77;  // beyond what such a caller has
  EXPECT_EQ(Open(Path(), &options), COSPLAT_OK);
  options = OpenOptions();
  options.bust = COSPLAT_BUST_STILL;
  EXPECT_EQ(Open(Path(), &options), COSPLAT_OK);
  options.bust = 2;
  EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_ARGUMENT);
  EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "bust: 2 is not"));
  options = OpenOptions();
  for (const uint32_t device : {COSPLAT_DEVICE_AUTO, COSPLAT_DEVICE_CPU}) {
    options.device = device;
    EXPECT_EQ(Open(Path(), &options), COSPLAT_OK);
  }
  options.device = COSPLAT_DEVICE_CUDA;
  setenv("CUDA_VISIBLE_DEVICES", "-1", 1);  // no GPU, whatever the machine has
  EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_DEVICE);
  EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "device: cuda"));
  options.device = 3;
  EXPECT_EQ(Open(Path(), &options), COSPLAT_ERROR_ARGUMENT);
}

TEST(PluginOpen, SaysFromWhereTheHeadWasFilmed) {
  cosplat_info info = Zeroed<cosplat_info>();
  ASSERT_EQ(cosplat_get_info(OpenAvatar(), &info), COSPLAT_OK);
  EXPECT_EQ(info.knows_filmed, 0u);

  const PluginFiles& files = PluginFiles::Get();
  AvatarModel filmed = files.avatar;
  filmed.filmed = FilmedFrom{{-0.1f, 0.3f}, {-0.2f, 0.2f}, {}};
  const OpenAvatar avatar(files.Write("filmed.glb", filmed));
  ASSERT_EQ(cosplat_get_info(avatar, &info), COSPLAT_OK);
  EXPECT_EQ(info.knows_filmed, 1u);
  EXPECT_NEAR(info.filmed_yaw[0], -0.1f, 1e-6f);
  EXPECT_NEAR(info.filmed_yaw[1], 0.3f, 1e-6f);
  EXPECT_NEAR(info.filmed_pitch[0], -0.2f, 1e-6f);
  EXPECT_NEAR(info.filmed_pitch[1], 0.2f, 1e-6f);

  // Pictures from beyond it, with a tolerance of 12 degrees, and of a head that turns away itself.
  std::vector<uint8_t> bytes;
  const cosplat_picture picture = PictureInto(bytes, 32, 32);
  const auto beyond = [&] {
    EXPECT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK) << cosplat_last_error(avatar);
    cosplat_health health = Zeroed<cosplat_health>();
    EXPECT_EQ(cosplat_get_health(avatar, &health), COSPLAT_OK);
    return health.beyond_film;
  };
  SetOrbit(avatar, 32, 32, 0);
  EXPECT_EQ(beyond(), 0u);
  SetOrbit(avatar, 32, 32, 0.45f);
  const uint64_t to_the_left = beyond();
  SetOrbit(avatar, 32, 32, -0.45f);
  EXPECT_EQ(to_the_left, 0u);
  EXPECT_EQ(beyond(), 1u);
  SetOrbit(avatar, 32, 32, 0, 0.8f);
  EXPECT_EQ(beyond(), 2u);
  SetOrbit(avatar, 32, 32, 0);
  EXPECT_EQ(beyond(), 2u);
  const float turned[3] = {0, 1, 0};
  ASSERT_EQ(cosplat_set_joint(avatar, COSPLAT_JOINT_NECK, turned, 0), COSPLAT_OK);
  EXPECT_EQ(beyond(), 3u);
}

// Of cosplat.h 0.2.
struct Info02 {
  uint32_t struct_size, gaussian_count, triangle_count, expression_count, joint_count;
  float box_min[3], box_max[3], background[3];
};

TEST(PluginStructs, AnOlderHostsInfoIsWrittenAsFarAsItGoes) {
  EXPECT_EQ(offsetof(Info02, gaussian_count), offsetof(cosplat_info, gaussian_count));
  EXPECT_EQ(offsetof(Info02, joint_count), offsetof(cosplat_info, joint_count));
  EXPECT_EQ(offsetof(Info02, box_min), offsetof(cosplat_info, box_min));
  EXPECT_EQ(offsetof(Info02, background), offsetof(cosplat_info, background));
  const OpenAvatar avatar;
  cosplat_info info;
  std::memset(&info, 0x5a, sizeof(info));
  info.struct_size = sizeof(Info02);
  ASSERT_EQ(cosplat_get_info(avatar, &info), COSPLAT_OK);
  EXPECT_EQ(info.gaussian_count, 1500u);
  EXPECT_EQ(info.knows_filmed, 0x5a5a5a5au);
  info.struct_size = sizeof(Info02) - 1;
  EXPECT_EQ(cosplat_get_info(avatar, &info), COSPLAT_ERROR_ARGUMENT);
}

// What a host sees that was built with a cosplat.h whose structures have grown.
TEST(PluginStructs, OfANewerHostMayBeLarger) {
  struct {
    cosplat_info info;
    uint64_t later;
  } newer_info;
  static_assert(offsetof(decltype(newer_info), later) >= sizeof(cosplat_info));
  newer_info.info.struct_size = sizeof(newer_info);
  newer_info.later = 7;
  const OpenAvatar avatar;
  ASSERT_EQ(cosplat_get_info(avatar, &newer_info.info), COSPLAT_OK);
  EXPECT_EQ(newer_info.info.struct_size, sizeof(newer_info));
  EXPECT_EQ(newer_info.info.gaussian_count, 1500u);
  EXPECT_EQ(newer_info.later, 0u);

  struct {
    cosplat_open_options options;
    uint64_t later;
  } newer_options{OpenOptions(), 0};
  newer_options.options.struct_size = sizeof(newer_options);
  EXPECT_EQ(Open(Path(), &newer_options.options), COSPLAT_OK);
  newer_options.later = 1;
  EXPECT_EQ(Open(Path(), &newer_options.options), COSPLAT_ERROR_ARGUMENT);
}

// Every function that takes a handle, with the handle alone being wrong.
std::vector<cosplat_status> CallAll(cosplat_avatar* avatar) {
  cosplat_info info = Zeroed<cosplat_info>();
  cosplat_parameters parameters = Zeroed<cosplat_parameters>();
  cosplat_camera camera = Zeroed<cosplat_camera>();
  std::vector<uint8_t> bytes;
  const cosplat_picture picture = PictureInto(bytes, 8, 8);
  const char* name;
  uint32_t index;
  const float three[3] = {0, 0, 0};
  return {cosplat_get_info(avatar, &info),
          cosplat_expression_name(avatar, 0, &name),
          cosplat_joint_name(avatar, 0, &name),
          cosplat_find_expression(avatar, "expression_0", &index),
          cosplat_find_joint(avatar, "jaw", &index),
          cosplat_set_parameters(avatar, &parameters),
          cosplat_get_parameters(avatar, &parameters),
          cosplat_set_expression(avatar, 0, 1, 0),
          cosplat_set_joint(avatar, 0, three, 0),
          cosplat_set_translation(avatar, three, 0),
          cosplat_reset_parameters(avatar),
          cosplat_orbit_camera(avatar, 8, 8, 0, 0, 1, &camera),
          cosplat_set_camera(avatar, &camera),
          cosplat_get_camera(avatar, &camera),
          cosplat_render(avatar, &picture)};
}

TEST(PluginHandle, WrongOnesAreRefused) {
  cosplat_avatar* closed = nullptr;
  const cosplat_open_options options = OpenOptions();
  ASSERT_EQ(cosplat_open(Path(), &options, &closed), COSPLAT_OK);
  for (const cosplat_status status : CallAll(closed)) EXPECT_EQ(status, COSPLAT_OK);
  ASSERT_EQ(cosplat_close(closed), COSPLAT_OK);
  EXPECT_EQ(cosplat_close(closed), COSPLAT_ERROR_HANDLE);
  EXPECT_EQ(cosplat_close(nullptr), COSPLAT_OK);
  const OpenAvatar open;  // another one's being there changes nothing
  int on_stack = 0;
  for (cosplat_avatar* wrong : {static_cast<cosplat_avatar*>(nullptr),
                                closed,
                                reinterpret_cast<cosplat_avatar*>(&on_stack),
                                reinterpret_cast<cosplat_avatar*>(uintptr_t(1)),
                                reinterpret_cast<cosplat_avatar*>(~uintptr_t(0))}) {
    for (const cosplat_status status : CallAll(wrong)) EXPECT_EQ(status, COSPLAT_ERROR_HANDLE);
    EXPECT_TRUE(Contains(cosplat_last_error(nullptr), "not an open avatar"));
    EXPECT_TRUE(Contains(cosplat_last_error(wrong), "not an open avatar"));
  }
}

TEST(PluginLastError, IsPerHandleAndPerThread) {
  const OpenAvatar a, b;
  EXPECT_STREQ(cosplat_last_error(a), "");
  EXPECT_EQ(cosplat_set_expression(a, 1000, 0, 0), COSPLAT_ERROR_NOT_FOUND);
  EXPECT_STREQ(cosplat_last_error(a), "expression: 1000 of 18");
  EXPECT_STREQ(cosplat_last_error(nullptr), cosplat_last_error(a));
  EXPECT_STREQ(cosplat_last_error(b), "");
  EXPECT_EQ(cosplat_set_expression(b, 0, NAN, 0), COSPLAT_ERROR_NOT_FINITE);
  EXPECT_STREQ(cosplat_last_error(b), "expression[0]: nan is not finite");
  EXPECT_STREQ(cosplat_last_error(nullptr), cosplat_last_error(b));
  EXPECT_EQ(cosplat_reset_parameters(a), COSPLAT_OK);  // what succeeds changes no text
  EXPECT_STREQ(cosplat_last_error(a), "expression: 1000 of 18");
  std::thread([&] {
    EXPECT_STREQ(cosplat_last_error(nullptr), "");
    EXPECT_STREQ(cosplat_last_error(b), "expression[0]: nan is not finite");
  }).join();
}

TEST(PluginLastError, LongTextsAreCut) {
  const std::string path(2000, 'x');
  const cosplat_open_options options = OpenOptions();
  EXPECT_EQ(Open(path.c_str(), &options), COSPLAT_ERROR_FILE);
  EXPECT_EQ(std::strlen(cosplat_last_error(nullptr)), 511u);
}

}  // namespace
}  // namespace cosplat::test
