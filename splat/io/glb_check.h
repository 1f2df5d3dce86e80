// Refuses a .glb file that a glTF library could misread or be led astray by.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

// Checks the container (magic, version 2, every length against the file's), the JSON (syntax,
// nesting) and, in the JSON, that
// - no buffer or image has a URI, and no extension outside `known_extensions` is required;
// - every buffer view lies within the binary chunk, every accessor within its buffer view, aligned
//   and not sparse; all their numbers are whole and not negative.
// Throws Error naming the field and its value.
void CheckGlb(const std::string& path,
              const std::vector<char>& bytes,
              const std::vector<std::string>& known_extensions);

}  // namespace cosplat
