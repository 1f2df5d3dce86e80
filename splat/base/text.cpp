#include "splat/base/text.h"

#include <cctype>
#include <cstdio>

namespace cosplat {
namespace {

template <class T>
std::string Printed(const std::string& format, T value) {
  char text[64];
  std::snprintf(text, sizeof text, format.c_str(), value);
  return text;
}

}  // namespace

std::string internal::NumberText(double value, std::string_view format) {
  return Printed(std::string("%").append(format), value);
}

std::string internal::NumberText(long long value, std::string_view format) {
  const std::string_view flags = format.substr(0, format.size() - 1);
  return Printed(std::string("%").append(flags).append("ll") + format.back(), value);
}

std::string WithThousands(size_t n) {
  std::string s = std::to_string(n);
  for (int i = int(s.size()) - 3; i > 0; i -= 3) s.insert(size_t(i), 1, ',');
  return s;
}

std::string LowerCase(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace cosplat
