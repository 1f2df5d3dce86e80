// libgstcosplat.so: registers cosplatsrc.
#include "apps/gstreamer/cosplat_src.h"

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
