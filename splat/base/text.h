// Text for messages and pages.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace cosplat {

namespace internal {

// By a printf format without its percent sign and, for integers, without the length: ".2f", "05d".
std::string NumberText(double value, std::string_view format);
std::string NumberText(long long value, std::string_view format);

template <class T>
std::string TextOf(const T& value, std::string_view format) {
  if constexpr (std::is_same_v<T, char>)
    return std::string(1, value);
  else if constexpr (!std::is_arithmetic_v<T>)
    return std::string(value);
  else if (format.empty())
    return std::to_string(value);
  else if constexpr (std::is_floating_point_v<T>)
    return NumberText(double(value), format);
  else
    return NumberText(static_cast<long long>(value), format);
}

}  // namespace internal

// `text` with each {} or {:FORMAT} replaced by the next value, as by std::format, which GCC 12
// lacks: Format("{} views, {:.2f} dB", views, psnr). Numbers without a format are std::to_string's.
// There must be as many {} as values.
template <class... Values>
std::string Format(std::string_view text, const Values&... values) {
  std::string out;
  const auto fill = [&](const auto& value) {
    const size_t begin = text.find('{'), end = text.find('}', begin);
    std::string_view format = text.substr(begin + 1, end - begin - 1);
    if (!format.empty()) format.remove_prefix(1);  // the colon
    out.append(text.substr(0, begin)).append(internal::TextOf(value, format));
    text.remove_prefix(end + 1);
  };
  (fill(values), ...);
  return out.append(text);
}

// 12345 -> "12,345".
std::string WithThousands(size_t n);

std::string LowerCase(std::string text);  // of ASCII

// The number that the text is, all of it; nothing if it is none, or does not fit.
template <class T>
std::optional<T> NumberOf(std::string_view text) {
  T number{};
  const char* const last = text.data() + text.size();
  const auto [end, code] = std::from_chars(text.data(), last, number);
  if (code != std::errc() || end != last) return {};
  return number;
}

}  // namespace cosplat
