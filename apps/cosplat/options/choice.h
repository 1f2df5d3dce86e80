// Options that take a name, and options that may be left open.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cosplat {

template <class T>
using Choices = std::vector<std::pair<std::string, T>>;  // names with their values

// The first name of the value; "" if it has none.
template <class T>
std::string NameIn(const Choices<T>& choices, const T& value) {
  for (const auto& [name, of_name] : choices)
    if (of_name == value) return name;
  return "";
}

// Declares an option that takes one of these names; the current value becomes the default. Both
// `choices` are copied.
template <class T>
CLI::Option* AddChoice(CLI::App& command,
                       const std::string& name,
                       T& value,
                       const Choices<T>& choices,
                       const std::string& description) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  const auto set = [&value, choices](const std::string& text) {
    for (const auto& [choice, of_choice] : choices)
      if (choice == text) value = of_choice;
  };
  return command.add_option_function<std::string>(name, set, description)
      ->check(CLI::IsMember(names))
      ->run_callback_for_default()
      ->default_str(NameIn(choices, value));
}

// Declares an option that is none unless it is given. open: a value that stands for none, too, as
// earlier versions had it.
template <class T>
CLI::Option* AddOptional(CLI::App& command,
                         const std::string& name,
                         std::optional<T>& value,
                         const std::string& description,
                         std::optional<T> open = std::nullopt) {
  const auto set = [&value, open](const T& given) {
    value = given == open ? std::nullopt : std::optional<T>(given);
  };
  return command.add_option_function<T>(name, set, description)->default_str("");
}

}  // namespace cosplat
