#include "splat/io/cameras_json.h"

#include <nlohmann/json.hpp>

#include "splat/base/files.h"

namespace cosplat {

void WriteCamerasJson(const std::string& path, const std::vector<NamedCamera>& cameras) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (size_t i = 0; i < cameras.size(); ++i) {
    const Camera& c = cameras[i].camera;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (int r = 0; r < 3; ++r)
      rows.push_back({c.rotation[r], c.rotation[3 + r], c.rotation[6 + r]});
    list.push_back({{"id", i},
                    {"img_name", cameras[i].name},
                    {"width", c.width},
                    {"height", c.height},
                    {"position", c.Center()},
                    {"rotation", rows},
                    {"fy", c.fy},
                    {"fx", c.fx}});
  }
  WriteFileAtomically(
      path, list.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace cosplat
