// `cosplat export --html`: a model with its player in one file.
#pragma once

#include <string>

#include "apps/cosplat/run/web_model.h"

namespace cosplat {

// Puts the model into the page that `npm run offline` made (apps/web/dist/offline.html) and writes
// it atomically. The FLAME model goes into it only if it may be passed on; otherwise the page asks
// for it. Throws Error if the page was not built or a file cannot be read or written.
void WriteWebPage(const std::string& path, const WebModel& model);

}  // namespace cosplat
