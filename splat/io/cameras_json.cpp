#include "splat/io/cameras_json.h"

#include <nlohmann/json.hpp>

#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

Camera CameraOf(const JsonField& json) {
  Camera c;
  c.width = json["width"].Integer();
  c.height = json["height"].Integer();
  c.fx = float(json["fx"].Number());
  c.fy = float(json["fy"].Number());
  if (c.width < 1 || c.height < 1 || !(c.fx > 0 && c.fy > 0))
    json.Fail("has a size or focal length that is not positive");
  c.cx = 0.5f * float(c.width);
  c.cy = 0.5f * float(c.height);
  const std::vector<float> rows = json["rotation"].Numbers(9), center = json["position"].Numbers(3);
  std::array<double, 9> rotation{};
  std::array<double, 3> translation{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) {
      rotation[3 * i + k] = rows[3 * k + i];
      translation[i] -= double(rows[3 * k + i]) * center[k];
    }
  const PoseProblem problem = SetPose(rotation, translation, c);
  if (!problem.empty()) throw Error(json.file(), json.path() + ".rotation", problem);
  return c;
}

}  // namespace

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

std::vector<NamedCamera> ReadCamerasJson(const std::string& path) {
  const JsonField list(path, ReadJson(path));
  std::vector<NamedCamera> cameras;
  for (size_t i = 0; i < list.size(); ++i)
    cameras.push_back({list[i]["img_name"].String(), CameraOf(list[i])});
  return cameras;
}

}  // namespace cosplat
