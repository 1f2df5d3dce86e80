#include "avatar/live/source.h"

#include "avatar/live/recording.h"

namespace cosplat {

std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options) {
  return OpenRecording(drive, options);
}

}  // namespace cosplat
