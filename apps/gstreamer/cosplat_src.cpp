// cosplatsrc: a GStreamer source that renders an avatar.
//
// properties -> AvatarView -> video/x-raw, RGBA or BGRA with straight alpha -> pipeline.
#include <gst/base/gstpushsrc.h>
#include <gst/video/video.h>

#include <memory>

#include "apps/gstreamer/frame_clock.h"
#include "apps/gstreamer/src_settings.h"

using cosplat::gstreamer::FrameClock;
using cosplat::gstreamer::FrameTime;
using cosplat::gstreamer::SrcSettings;
using cosplat::gstreamer::SrcStats;
using cosplat::hosts::AvatarView;
using cosplat::hosts::ViewError;

G_BEGIN_DECLS
G_DECLARE_FINAL_TYPE(CosplatSrc, cosplat_src, COSPLAT, SRC, GstPushSrc)
G_END_DECLS

GST_DEBUG_CATEGORY_STATIC(cosplat_src_debug);
#define GST_CAT_DEFAULT cosplat_src_debug

// Not in the anonymous namespace, since GObject's macros give _CosplatSrc linkage.
struct CosplatSrcState {
  SrcSettings settings;              // under the object lock
  SrcStats stats;                    // likewise
  std::unique_ptr<AvatarView> view;  // while started
  GstVideoInfo info;
  FrameClock clock;
  bool ended = false;  // the drive will deliver no more frames
};

namespace {

constexpr guint kStats = 100;  // a property number that no setting uses

}  // namespace

struct _CosplatSrc {
  GstPushSrc parent;
  CosplatSrcState* state;
};

G_DEFINE_FINAL_TYPE(CosplatSrc, cosplat_src, GST_TYPE_PUSH_SRC)

namespace {

GstStaticPadTemplate pad_template =
    GST_STATIC_PAD_TEMPLATE("src",
                            GST_PAD_SRC,
                            GST_PAD_ALWAYS,
                            GST_STATIC_CAPS("video/x-raw, format = { RGBA, BGRA }, "
                                            "width = [ 1, 16384 ], height = [ 1, 16384 ], "
                                            "framerate = [ 1/1000, 1000/1 ], "
                                            "interlace-mode = progressive, "
                                            "pixel-aspect-ratio = 1/1, colorimetry = sRGB"));

CosplatSrcState& StateOf(gpointer object) { return *COSPLAT_SRC(object)->state; }

// A copy, since any thread may set properties.
SrcSettings SettingsOf(gpointer object) {
  GST_OBJECT_LOCK(object);
  SrcSettings settings = StateOf(object).settings;
  GST_OBJECT_UNLOCK(object);
  return settings;
}

void SetProperty(GObject* object, guint property, const GValue* value, GParamSpec* spec) {
  GST_OBJECT_LOCK(object);
  const bool known = SetSetting(StateOf(object).settings, property, value);
  const bool live = StateOf(object).settings.is_live;
  GST_OBJECT_UNLOCK(object);
  if (!known) G_OBJECT_WARN_INVALID_PROPERTY_ID(object, property, spec);
  gst_base_src_set_live(GST_BASE_SRC(object), live);
}

void GetProperty(GObject* object, guint property, GValue* value, GParamSpec* spec) {
  CosplatSrcState& state = StateOf(object);
  GST_OBJECT_LOCK(object);
  const bool known = GetSetting(state.settings, property, value);
  if (property == kStats) g_value_take_boxed(value, ToStructure(state.stats));
  GST_OBJECT_UNLOCK(object);
  if (!known && property != kStats) G_OBJECT_WARN_INVALID_PROPERTY_ID(object, property, spec);
}

void Finalize(GObject* object) {
  delete COSPLAT_SRC(object)->state;
  G_OBJECT_CLASS(cosplat_src_parent_class)->finalize(object);
}

void PostError(gpointer src, const ViewError& error) {
  if (error.status() == COSPLAT_ERROR_FILE || error.status() == COSPLAT_ERROR_FLAME) {
    GST_ELEMENT_ERROR(src, RESOURCE, OPEN_READ, ("%s", error.what()), (nullptr));
  } else {
    GST_ELEMENT_ERROR(src, RESOURCE, SETTINGS, ("%s", error.what()), (nullptr));
  }
}

// A live drive does not wait: a pipeline without a clock of its own makes a whole film of its first
// face.
bool IsLiveDrive(const std::string& drive) {
  return drive.find("://") != drive.npos || drive.starts_with("webcam:") || drive == "audio:";
}

gboolean Start(GstBaseSrc* src) {
  const SrcSettings settings = SettingsOf(src);
  CosplatSrcState& state = StateOf(src);
  try {
    state.view = std::make_unique<AvatarView>(settings.view);
  } catch (const ViewError& error) {
    PostError(src, error);
    return FALSE;
  }
  if (!settings.is_live && IsLiveDrive(settings.view.drive))
    GST_ELEMENT_WARNING(
        src,
        RESOURCE,
        SETTINGS,
        ("drive: %s comes at the clock's pace, is-live=false may not", settings.view.drive.c_str()),
        (nullptr));
  state.clock.Reset();
  state.ended = false;
  GST_OBJECT_LOCK(src);
  state.stats = {};
  GST_OBJECT_UNLOCK(src);
  return TRUE;
}

gboolean Stop(GstBaseSrc* src) {
  StateOf(src).view.reset();
  return TRUE;
}

// Not for a pause: the frame that is due ends by itself. A thread that came back to the base class
// as flushing after the pause was over would not be started again.
gboolean Unlock(GstBaseSrc* src) {
  if (GST_PAD_IS_FLUSHING(GST_BASE_SRC_PAD(src))) StateOf(src).clock.Unlock();
  return TRUE;
}

gboolean UnlockStop(GstBaseSrc* src) {
  StateOf(src).clock.UnlockStop();
  return TRUE;
}

GstCaps* Fixate(GstBaseSrc* src, GstCaps* caps) {
  const SrcSettings settings = SettingsOf(src);
  caps = gst_caps_make_writable(gst_caps_truncate(caps));
  GstStructure* structure = gst_caps_get_structure(caps, 0);
  gst_structure_fixate_field_nearest_int(structure, "width", settings.width);
  gst_structure_fixate_field_nearest_int(structure, "height", settings.height);
  gst_structure_fixate_field_nearest_fraction(
      structure, "framerate", settings.fps.numerator, settings.fps.denominator);
  return GST_BASE_SRC_CLASS(cosplat_src_parent_class)->fixate(src, caps);
}

gboolean SetCaps(GstBaseSrc* src, GstCaps* caps) {
  CosplatSrcState& state = StateOf(src);
  if (!gst_video_info_from_caps(&state.info, caps)) return FALSE;
  state.clock.SetRate(state.info.fps_n, state.info.fps_d);
  gst_base_src_set_blocksize(src, guint(state.info.size));
  if (SettingsOf(src).is_live)  // the latency depends on the frame rate
    gst_element_post_message(GST_ELEMENT(src), gst_message_new_latency(GST_OBJECT(src)));
  return TRUE;
}

// Takes frames from a pool, downstream's if it has one, so that memory is reused.
gboolean DecideAllocation(GstBaseSrc* src, GstQuery* query) {
  CosplatSrcState& state = StateOf(src);
  GstBufferPool* pool = nullptr;
  guint size = guint(state.info.size), min = 0, max = 0;
  const bool offered = gst_query_get_n_allocation_pools(query) > 0;
  if (offered) gst_query_parse_nth_allocation_pool(query, 0, &pool, &size, &min, &max);
  if (!pool) pool = gst_video_buffer_pool_new();
  size = MAX(size, guint(state.info.size));
  GstCaps* caps = nullptr;
  gst_query_parse_allocation(query, &caps, nullptr);
  GstStructure* config = gst_buffer_pool_get_config(pool);
  gst_buffer_pool_config_set_params(config, caps, size, min, max);
  if (gst_query_find_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr))
    gst_buffer_pool_config_add_option(config, GST_BUFFER_POOL_OPTION_VIDEO_META);
  gst_buffer_pool_set_config(pool, config);
  if (offered) {
    gst_query_set_nth_allocation_pool(query, 0, pool, size, min, max);
  } else {
    gst_query_add_allocation_pool(query, pool, size, min, max);
  }
  gst_object_unref(pool);
  return GST_BASE_SRC_CLASS(cosplat_src_parent_class)->decide_allocation(src, query);
}

// A live frame is rendered at its time and pushed when it is finished, at most one frame duration
// later. The maximum latency is unlimited: frames that are not consumed are not rendered.
gboolean Query(GstBaseSrc* src, GstQuery* query) {
  CosplatSrcState& state = StateOf(src);
  if (GST_QUERY_TYPE(query) != GST_QUERY_LATENCY)
    return GST_BASE_SRC_CLASS(cosplat_src_parent_class)->query(src, query);
  const bool live = SettingsOf(src).is_live;
  gst_query_set_latency(query, live, live ? state.clock.Duration() : 0, GST_CLOCK_TIME_NONE);
  return TRUE;
}

void Draw(CosplatSrcState& state,
          const SrcSettings& settings,
          GstClockTime now,
          GstVideoFrame& frame) {
  const auto background = cosplat::hosts::ParseBackground(settings.background);
  if (!background)
    throw ViewError(
        COSPLAT_ERROR_ARGUMENT,
        "background: '" + settings.background + "' is not avatar, transparent or #rrggbb");
  cosplat_picture picture{};
  picture.struct_size = sizeof(picture);
  picture.width = guint(GST_VIDEO_FRAME_WIDTH(&frame));
  picture.height = guint(GST_VIDEO_FRAME_HEIGHT(&frame));
  const bool rgba = GST_VIDEO_FRAME_FORMAT(&frame) == GST_VIDEO_FORMAT_RGBA;
  picture.format = rgba ? COSPLAT_FORMAT_RGBA8 : COSPLAT_FORMAT_BGRA8;
  picture.pixels = GST_VIDEO_FRAME_PLANE_DATA(&frame, 0);
  picture.stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0);
  state.view->Advance(int64_t(now));
  state.view->Draw(settings.orbit, *background, COSPLAT_ALPHA_STRAIGHT, picture);
}

// Renders into the buffer's memory; returns false after posting an error.
bool DrawInto(GstPushSrc* src, GstBuffer* buffer, GstClockTime now) {
  CosplatSrcState& state = StateOf(src);
  GstVideoFrame frame;
  if (!gst_video_frame_map(&frame, &state.info, buffer, GST_MAP_WRITE)) {
    GST_ELEMENT_ERROR(src, RESOURCE, WRITE, ("The frame's memory cannot be written"), (nullptr));
    return false;
  }
  bool drawn = true;
  try {
    Draw(state, SettingsOf(src), now, frame);
  } catch (const ViewError& error) {
    PostError(src, error);
    drawn = false;
  }
  gst_video_frame_unmap(&frame);
  return drawn;
}

void Count(GstPushSrc* src, const FrameTime& time) {
  CosplatSrcState& state = StateOf(src);
  const cosplat_health health = state.view->Health();
  state.ended = health.drive_ended;
  GST_OBJECT_LOCK(src);
  ++state.stats.frames;
  state.stats.left_out = time.number + 1 - state.stats.frames;
  const bool problem = Update(state.stats, health);
  GST_OBJECT_UNLOCK(src);
  if (problem) GST_WARNING_OBJECT(src, "drive: %s", health.drive_problem);
}

void Stamp(GstBuffer* buffer, const FrameTime& time) {
  GST_BUFFER_PTS(buffer) = time.pts;
  GST_BUFFER_DURATION(buffer) = time.duration;
  GST_BUFFER_OFFSET(buffer) = time.number;
  GST_BUFFER_OFFSET_END(buffer) = time.number + 1;
  if (time.gap) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
}

GstFlowReturn Fill(GstPushSrc* src, GstBuffer* buffer) {
  CosplatSrcState& state = StateOf(src);
  const bool live = gst_base_src_is_live(GST_BASE_SRC(src));
  if (state.ended && !live) return GST_FLOW_EOS;
  FrameTime time = state.clock.Next();
  if (live && !state.clock.WaitForNext(GST_ELEMENT(src), time)) return GST_FLOW_FLUSHING;
  gst_object_sync_values(GST_OBJECT(src), time.pts);
  if (!DrawInto(src, buffer, time.pts)) return GST_FLOW_ERROR;
  Stamp(buffer, time);
  Count(src, time);
  state.clock.Made(time);
  return GST_FLOW_OK;
}

}  // namespace

static void cosplat_src_init(CosplatSrc* src) {
  src->state = new CosplatSrcState;
  gst_video_info_init(&src->state->info);
  gst_base_src_set_format(GST_BASE_SRC(src), GST_FORMAT_TIME);
}

static void DescribeElement(GstElementClass* element_class) {
  gst_element_class_set_static_metadata(element_class,
                                        "CoSplat avatar",
                                        "Source/Video",
                                        "Pictures of a head avatar, at rest or driven",
                                        "The CoSplat contributors");
  gst_element_class_add_static_pad_template(element_class, &pad_template);
}

static void cosplat_src_class_init(CosplatSrcClass* src_class) {
  GST_DEBUG_CATEGORY_INIT(cosplat_src_debug, "cosplatsrc", 0, "CoSplat avatars");
  GObjectClass* object_class = G_OBJECT_CLASS(src_class);
  object_class->set_property = SetProperty;
  object_class->get_property = GetProperty;
  object_class->finalize = Finalize;
  cosplat::gstreamer::InstallProperties(object_class);
  g_object_class_install_property(
      object_class,
      kStats,
      g_param_spec_boxed("stats",
                         "Statistics",
                         "Of the face and its drive, after the last frame",
                         GST_TYPE_STRUCTURE,
                         GParamFlags(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)));
  DescribeElement(GST_ELEMENT_CLASS(src_class));
  GstBaseSrcClass* base_class = GST_BASE_SRC_CLASS(src_class);
  base_class->start = Start;
  base_class->stop = Stop;
  base_class->unlock = Unlock;
  base_class->unlock_stop = UnlockStop;
  base_class->fixate = Fixate;
  base_class->set_caps = SetCaps;
  base_class->decide_allocation = DecideAllocation;
  base_class->query = Query;
  GST_PUSH_SRC_CLASS(src_class)->fill = Fill;
}

// Plug-in entry point of libgstcosplat.so, which registers cosplatsrc.
#define PACKAGE "cosplat"

static gboolean plugin_init(GstPlugin* plugin) {
  return gst_element_register(plugin, "cosplatsrc", GST_RANK_NONE, cosplat_src_get_type());
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR,
                  GST_VERSION_MINOR,
                  cosplat,
                  "Head avatars of Gaussian splats",
                  plugin_init,
                  COSPLAT_VERSION_TEXT,
                  "Apache 2.0",
                  "CoSplat",
                  "CoSplat")
