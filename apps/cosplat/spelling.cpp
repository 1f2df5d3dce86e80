#include "apps/cosplat/spelling.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace cosplat {
namespace {

// Letters to insert, remove or replace (Levenshtein 1966).
size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, replaced});
    }
  }
  return row.back();
}

// The nearest of the names, or "" if more than a third of the letters differ.
std::string Nearest(const std::string& word, const std::vector<std::string>& names) {
  std::string nearest;
  size_t least = std::max(size_t(2), word.size() / 3) + 1;
  for (const std::string& name : names) {
    const size_t distance = EditDistance(word, name);
    if (distance < least) {
      least = distance;
      nearest = name;
    }
  }
  return nearest;
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

}  // namespace

std::string UnknownArgument(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty()) return "";
  const std::string word = unknown[0].substr(0, unknown[0].find('='));
  const std::vector<CLI::App*> commands = app.get_subcommands();
  std::vector<std::string> names;
  std::string text = "'" + word + "' is no ";
  if (word.starts_with("-")) {
    names = OptionNames(app);
    for (const CLI::App* command : commands)
      for (const std::string& name : OptionNames(*command)) names.push_back(name);
    text += commands.empty() ? "option" : "option of " + commands[0]->get_name();
  } else if (commands.empty()) {
    if (word == "study" || word == "bench")
      return "'" + word + "' is of the program cosplat-study (docs/study.md)";
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    text += "command";
  } else {
    return "'" + word + "' belongs to no option of " + commands[0]->get_name();
  }
  const std::string nearest = Nearest(word, names);
  return nearest.empty() ? text : text + ": did you mean " + nearest + "?";
}

}  // namespace cosplat
