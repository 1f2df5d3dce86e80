// The project's only exception type: an error in an input, identified by file, field and value.
//
// Commands print what() on one line and exit with code 2; the C ABI turns it into a status code.
#pragma once

#include <stdexcept>
#include <string>

namespace cosplat {

class Error : public std::runtime_error {
 public:
  // `file`: the path (or option) that the input came from; `field`: where in it, may be empty;
  // `problem`: what was found and what was expected, with the offending value.
  Error(const std::string& file, const std::string& field, const std::string& problem)
      : std::runtime_error(Format(file, field, problem)) {}
  // For an error about a whole file, or about an option, argument or device.
  Error(const std::string& what, const std::string& problem) : Error(what, "", problem) {}

 private:
  static std::string Format(const std::string& file,
                            const std::string& field,
                            const std::string& problem) {
    std::string text = file;
    if (!field.empty()) text += text.empty() ? field : ": " + field;
    return OneLine(text.empty() ? problem : text + ": " + problem);
  }
  // Names and values are quoted from files of strangers: control characters, which could end the
  // line or command a terminal, become \xNN, and what is long is cut.
  static std::string OneLine(const std::string& text) {
    constexpr size_t kMaxLength = 800;
    constexpr const char* kDigits = "0123456789abcdef";
    std::string line;
    for (const char c : text) {
      const unsigned char byte = static_cast<unsigned char>(c);
      if (byte >= 0x20 && byte != 0x7f)
        line += c;
      else
        line += std::string("\\x") + kDigits[byte >> 4] + kDigits[byte & 15];
      if (line.size() > kMaxLength) return line + "...";
    }
    return line;
  }
};

}  // namespace cosplat
