#include "apps/cosplat/options/command_line.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

namespace cosplat {
namespace {

class Help : public CLI::Formatter {
 public:
  Help() { column_width(34); }

  // An earlier spelling is accepted, but not listed.
  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    if (positional) return option->get_name(true, false);
    const std::vector<std::string>& shorts = option->get_snames();
    const std::vector<std::string>& longs = option->get_lnames();
    std::string name = shorts.empty() ? "" : "-" + shorts[0];
    if (!longs.empty()) name += (name.empty() ? "--" : ",--") + longs[0];
    return name;
  }

  std::string make_help(const CLI::App* app,
                        std::string name,
                        CLI::AppFormatMode mode) const override {
    ranges_ = mode != CLI::AppFormatMode::Normal;
    if (mode == CLI::AppFormatMode::Sub) return CLI::Formatter::make_help(app, name, mode);
    return Lines(make_description(app)) + Lines(make_usage(app, name)) + make_positionals(app) +
           Groups(*app, mode) + make_subcommands(app, mode);
  }

  // Without folding descriptions, which later versions of CLI11 do.
  std::string make_option(const CLI::Option* option, bool positional) const override {
    std::string line = "  " + make_option_name(option, positional) + make_option_opts(option);
    const std::string description = make_option_desc(option);
    if (!description.empty()) {
      if (line.size() >= get_column_width()) line += "\n" + std::string(get_column_width(), ' ');
      line.resize(std::max(line.size(), get_column_width()), ' ');
      line += description;
    }
    return line + "\n";
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    return ranges_ ? CLI::Formatter::make_option_opts(option) : ShortOpts(*option);
  }

 private:
  std::string Groups(const CLI::App& app, CLI::AppFormatMode mode) const {
    std::string text;
    size_t left = 0;
    for (const std::string& group : app.get_groups()) {
      const std::vector<const CLI::Option*> options =
          app.get_options([&](const CLI::Option* option) {
            return option->get_group() == group && option->nonpositional();
          });
      if (group.empty() || options.empty()) continue;
      if (group.starts_with("More") && mode == CLI::AppFormatMode::Normal)
        left += options.size();
      else
        text += make_group(group, false, options);
    }
    if (left > 0) text += "\n" + std::to_string(left) + " more options: --help-all\n";
    return text;
  }

  // Versions of CLI11 differ in the empty lines around a text; here there are none.
  static std::string Lines(const std::string& text) {
    const size_t first = text.find_first_not_of('\n'), last = text.find_last_not_of("\n ");
    return first == std::string::npos ? "" : text.substr(first, last + 1 - first) + "\n";
  }

  // What it takes, and its default, without ranges.
  std::string ShortOpts(const CLI::Option& option) const {
    std::string text;
    if (option.get_type_size() != 0) {
      const std::string type = option.get_type_name();
      const size_t choices = type.find('{'), range = type.find(':');
      text = " " + (choices != std::string::npos ? type.substr(choices) : type.substr(0, range));
      if (option.get_expected_max() == CLI::detail::expected_max_vector_size) text += " ...";
    }
    if (!option.get_default_str().empty() && option.get_type_size() != 0)
      text += "=" + option.get_default_str();
    return option.get_required() ? text + " REQUIRED" : text;
  }

  mutable bool ranges_ = false;  // of the text that is being made
};

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

void BeginGroup(CLI::App& command, const std::string& name) {
  command.option_defaults()->group(name);
}

std::shared_ptr<CLI::Formatter> MakeHelp() { return std::make_shared<Help>(); }

std::string ConfigOf(const CLI::App& app, const CLI::App& command) {
  const std::string begin = command.get_name() + ".";
  std::string all = app.get_config_formatter()->to_config(&command, true, true, begin);
  all.resize(all.find_last_not_of('\n') + 1);
  std::string text = std::string(kSecondFormat) + "\n";
  // Later versions of CLI11 list options that are left open, too, and then refuse the empty value.
  const auto is_open = [&](const std::string& paragraph) {
    const size_t name = paragraph.rfind('\n' + begin), equals = paragraph.rfind("=\"\"");
    if (name == paragraph.npos || equals == paragraph.npos || equals + 3 < paragraph.size())
      return false;
    const size_t first = name + 1 + begin.size();
    const CLI::Option* option =
        command.get_option_no_throw("--" + paragraph.substr(first, equals - first));
    return option && option->empty();
  };
  for (size_t at = 0; at < all.size();) {
    const size_t end = std::min(all.find("\n\n", at), all.size());
    const std::string paragraph = all.substr(at, end - at);
    if (!is_open(paragraph)) text += paragraph + "\n\n";
    at = end + 2;
  }
  return text;
}

void AddConfig(CLI::App& app) {
  app.config_formatter(std::make_shared<ConfigFormat>());
  app.set_config("--config", "", "read options from a file that an earlier run wrote (config.ini)");
}

}  // namespace cosplat
