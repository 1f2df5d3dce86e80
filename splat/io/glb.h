// Binary glTF 2.0 files, as far as splats and meshes need them: accessors over one binary chunk,
// meshes, and extensions as JSON.
//
// writer: AddFloats, AddUnsigned -> GlbDocument -> WriteGlb;  reader: ReadGlb -> GlbDocument ->
// ReadFloats, ReadUnsigned. The bytes go through tinygltf (glb_tinygltf.cpp, the only file that
// sees it); since that validates nothing, glb_check.h does first.
// Source: Khronos, glTF 2.0 specification, sections 3.6 (accessors) and 4 (GLB).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "splat/base/json.h"
#include "splat/device/buffer.h"

namespace cosplat {

// glTF's own numbers.
enum GlbComponent { kGlbUint32 = 5125, kGlbFloat = 5126 };
enum GlbMode { kGlbPoints = 0, kGlbTriangles = 4 };

// What an accessor is for. Positions carry bounds; indices and attributes say so to GPU loaders.
enum class GlbUse { kData, kAttribute, kPosition, kIndices };

struct GlbAccessor {
  int component = kGlbFloat;  // or any other of glTF's, as read
  int width = 1;              // numbers per element: 1 to 4
  size_t count = 0;
  size_t offset = 0;  // bytes into GlbDocument::binary
  size_t stride = 0;  // bytes from one element to the next
  GlbUse use = GlbUse::kData;
};

struct GlbPrimitive {
  int mode = kGlbTriangles;
  std::map<std::string, int> attributes;            // semantic -> accessor
  int indices = -1;                                 // accessor, or -1
  std::vector<std::map<std::string, int>> targets;  // morph targets
  Json extensions = Json::object();
};

struct GlbMesh {
  std::string name;
  std::vector<GlbPrimitive> primitives;
  Json extras;  // null: none
};

// Each mesh of a scene stands under a node of its own, without a transform.
struct GlbScene {
  std::string name;
  std::vector<int> meshes;
};

struct GlbDocument {
  std::string path;  // for errors
  std::vector<unsigned char> binary;
  std::vector<GlbAccessor> accessors;
  std::vector<GlbMesh> meshes;
  std::vector<GlbScene> scenes;  // the first is shown; written only, ReadGlb leaves it empty
  std::vector<std::string> extensions_used;
};

// Append values, tightly packed, and return the accessor's index. values: [count, width], count at
// least 1 (an accessor cannot be empty: Error).
int AddFloats(GlbDocument& document, View<const float> values, int width, GlbUse use);
int AddUnsigned(GlbDocument& document, View<const uint32_t> values, GlbUse use);

// [count, width] of an accessor; `field` says in errors who asked for it. Error when there is no
// such accessor, it has other components or another width, or (floats) a value is not finite.
std::vector<float> ReadFloats(const GlbDocument& document,
                              int accessor,
                              int width,
                              const std::string& field);
std::vector<uint32_t> ReadUnsigned(const GlbDocument& document,
                                   int accessor,
                                   const std::string& field);

// Atomic. Error when the file would pass GLB's 4 GiB.
void WriteGlb(const GlbDocument& document);

// Reads nothing but this file: a URI, within or beside it, is an Error. So is everything that
// CheckGlb finds, and an extension that the file requires and `known_extensions` lacks.
GlbDocument ReadGlb(const std::string& path, const std::vector<std::string>& known_extensions);
// The same of a file's bytes; `path` is for errors.
GlbDocument ParseGlb(const std::string& path,
                     const std::vector<char>& bytes,
                     const std::vector<std::string>& known_extensions);

// Refuses a .glb file that a glTF library could misread or be led astray by.

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
