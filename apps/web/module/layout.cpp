// What the page needs besides cosplat.h: where the fields of its structures are, for
// apps/web/src/structs.js, which reads and writes them in the module's memory; and the number of
// threads.
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

#include "avatar/plugin/cosplat.h"
#include "avatar/plugin/splats.h"

namespace {

// JSON's name of a field's type, by its elements if it is an array.
template <class Field>
const char* TypeOf() {
  using T = std::remove_all_extents_t<Field>;
  if (std::is_same_v<T, const char*>) return "text";
  if (std::is_pointer_v<T>) return "pointer";
  if (std::is_same_v<T, float>) return "f32";
  if (sizeof(T) == 8) return std::is_signed_v<T> ? "i64" : "u64";
  return "u32";
}

template <class Field>
void Add(const char* name, size_t offset, std::string& fields) {
  using T = std::remove_all_extents_t<Field>;
  if (!fields.empty()) fields += ",";
  fields += std::string("\"") + name + "\":[\"" + TypeOf<Field>() + "\"," + std::to_string(offset) +
            "," + std::to_string(sizeof(Field) / sizeof(T)) + "]";
}

std::string StructText(const char* name, size_t bytes, const std::string& fields) {
  return std::string("\"") + name + "\":{\"bytes\":" + std::to_string(bytes) + ",\"fields\":{" +
         fields + "}}";
}

#define FIELD(field) Add<decltype(Struct::field)>(#field, offsetof(Struct, field), fields)
#define BEGIN(name)      \
  {                      \
    using Struct = name; \
    std::string fields;  \
    const char* title = #name;
#define END()                                                                    \
  text += (text.empty() ? "" : ",") + StructText(title, sizeof(Struct), fields); \
  }

std::string Layout() {
  std::string text;
  BEGIN(cosplat_open_options)
  FIELD(struct_size), FIELD(device), FIELD(flame_path), FIELD(bust);
  END()
  BEGIN(cosplat_info)
  FIELD(struct_size), FIELD(gaussian_count), FIELD(triangle_count), FIELD(expression_count);
  FIELD(joint_count), FIELD(box_min), FIELD(box_max), FIELD(background);
  FIELD(knows_filmed), FIELD(filmed_yaw), FIELD(filmed_pitch);
  END()
  BEGIN(cosplat_parameters)
  FIELD(struct_size), FIELD(expression_count), FIELD(expression), FIELD(time_ns);
  FIELD(joints), FIELD(translation);
  END()
  BEGIN(cosplat_policy)
  FIELD(struct_size), FIELD(hold_s), FIELD(decay_s), FIELD(blend_in_s), FIELD(range);
  FIELD(smoothing), FIELD(min_cutoff_hz), FIELD(beta), FIELD(loop), FIELD(frames_per_second);
  END()
  BEGIN(cosplat_health)
  FIELD(struct_size), FIELD(face), FIELD(age_s), FIELD(drive_ended), FIELD(accepted);
  FIELD(replaced), FIELD(late), FIELD(not_finite), FIELD(out_of_range), FIELD(wrong_size);
  FIELD(softened), FIELD(held), FIELD(decayed), FIELD(returned), FIELD(drive_frames);
  FIELD(drive_replaced), FIELD(drive_reordered), FIELD(drive_malformed), FIELD(drive_oversize);
  FIELD(drive_flooded), FIELD(drive), FIELD(drive_problem), FIELD(drive_packets);
  FIELD(drive_unusable), FIELD(drive_notes), FIELD(beyond_film);
  END()
  BEGIN(cosplat_camera)
  FIELD(struct_size), FIELD(width), FIELD(height), FIELD(fx), FIELD(fy), FIELD(cx), FIELD(cy);
  FIELD(cam_from_world);
  END()
  BEGIN(cosplat_picture)
  FIELD(struct_size), FIELD(width), FIELD(height), FIELD(format), FIELD(alpha);
  FIELD(background), FIELD(pixels), FIELD(stride), FIELD(depth), FIELD(depth_stride);
  END()
  BEGIN(cosplat_splats)
  FIELD(struct_size), FIELD(width), FIELD(height), FIELD(fx), FIELD(fy), FIELD(cx), FIELD(cy);
  FIELD(cam_from_world), FIELD(count), FIELD(centers), FIELD(colors), FIELD(scales);
  FIELD(rotations);
  END()
  return "{" + text + "}";
}

}  // namespace

// {"STRUCT": {"bytes": N, "fields": {"FIELD": [TYPE, offset in bytes, count]}}}.
extern "C" const char* cosplat_web_layout() {
  static const std::string text = Layout();
  return text.c_str();
}

// How many threads draw, the caller's included; before anything is opened.
extern "C" void cosplat_web_use_threads(uint32_t threads) { tbb::lean::Pool::UseThreads(threads); }
