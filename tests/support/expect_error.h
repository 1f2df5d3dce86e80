// Bad input must give one line that names what is wrong.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "splat/base/error.h"

namespace cosplat::test {

// `action` must throw Error with a one-line message that contains every part.
inline void ExpectError(const std::function<void()>& action,
                        const std::vector<std::string>& parts) {
  try {
    action();
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    for (const std::string& part : parts)
      EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
    return;
  }
  FAIL() << "no Error where one should name " << (parts.empty() ? "the problem" : parts[0]);
}

}  // namespace cosplat::test
