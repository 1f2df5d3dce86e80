// cosplatsrc: a GStreamer source of pictures of an avatar.
//
// properties -> AvatarView -> video/x-raw, RGBA or BGRA with straight alpha -> pipeline.
#pragma once

#include <gst/base/gstpushsrc.h>

G_BEGIN_DECLS
G_DECLARE_FINAL_TYPE(CosplatSrc, cosplat_src, COSPLAT, SRC, GstPushSrc)
G_END_DECLS
