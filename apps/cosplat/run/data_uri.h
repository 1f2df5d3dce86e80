// Files inside a page, so that it needs nothing beside it.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

// "data:image/png;base64,...".
std::string DataUri(const std::string& media_type, const std::vector<char>& bytes);

}  // namespace cosplat
