#include "apps/cosplat/options/config_file.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

namespace cosplat {
namespace {

// A line of files in which an option that is left open is not listed: the first, unless they were
// edited.
constexpr const char* kSecondFormat = "# options, format 2";

// What stood for an option left open before.
const std::vector<std::pair<std::string, double>>& OnceOpen() {
  static const std::vector<std::pair<std::string, double>> values{
      {"position_lr_final", 0},
      {"rest-lr", 0},
      {"rest_lr", 0},
      {"scaling_lr", 0},
  };
  return values;
}

bool WasOpen(const CLI::ConfigItem& item) {
  return std::any_of(OnceOpen().begin(), OnceOpen().end(), [&](const auto& open) {
    return item.name == open.first && item.inputs.size() == 1 &&
           std::strtod(item.inputs[0].c_str(), nullptr) == open.second;
  });
}

class ConfigFormat : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    const std::string text((std::istreambuf_iterator<char>(input)), {});
    std::istringstream stream(text);
    std::vector<CLI::ConfigItem> items = CLI::ConfigTOML::from_config(stream);
    const bool is_second = ("\n" + text).find(std::string("\n") + kSecondFormat) != text.npos;
    if (!is_second) std::erase_if(items, WasOpen);
    return items;
  }
};

}  // namespace

std::string ConfigOf(const CLI::App& app, const CLI::App& command) {
  return std::string(kSecondFormat) + "\n" +
         app.get_config_formatter()->to_config(&command, true, true, command.get_name() + ".");
}

void AddConfig(CLI::App& app) {
  app.config_formatter(std::make_shared<ConfigFormat>());
  app.set_config("--config", "", "read options from a file that an earlier run wrote (config.ini)");
}

}  // namespace cosplat
