// Binary glTF 2.0 files, to the extent that splats and meshes need: accessors over one binary
// chunk, meshes, and extensions as JSON.
//
// writer: AddValues -> GlbDocument -> WriteGlb; reader: ReadGlb -> GlbDocument -> ReadValues.
// The bytes go through tinygltf (only glb_tinygltf.cpp includes it); since tinygltf validates
// nothing, CheckGlb runs first.
// Source: Khronos, glTF 2.0 specification, sections 3.6 (accessors) and 4 (GLB).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "splat/base/json.h"
#include "splat/device/buffer.h"

namespace cosplat {

// Numeric values of the glTF specification.
enum GlbComponent { kGlbUint8 = 5121, kGlbInt16 = 5122, kGlbUint32 = 5125, kGlbFloat = 5126 };
enum GlbMode { kGlbPoints = 0, kGlbTriangles = 4 };

// What an accessor is for. Positions get bounds; indices and attributes get a buffer view target.
enum class GlbUse { kData, kAttribute, kPosition, kIndices };

struct GlbAccessor {
  int component = kGlbFloat;  // when read, any of glTF's component types
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
  // Translation of its node, in doubles as JSON has them. Read from a node that has no other
  // transform.
  std::array<double, 3> translation{};
};

// Each mesh of a scene is attached to its own node.
struct GlbScene {
  std::string name;
  std::vector<int> meshes;
};

struct GlbDocument {
  std::string path;  // for errors
  std::vector<unsigned char> binary;
  std::vector<GlbAccessor> accessors;
  std::vector<GlbMesh> meshes;
  std::vector<GlbScene> scenes;  // the first is the default; ReadGlb does not fill it
  std::vector<std::string> extensions_used;
  bool has_transforms = false;  // of ReadGlb: a node has one that is not the identity
};

// Appends values, tightly packed, and returns the accessor's index. T: float, int16_t, uint32_t, or
// char for bytes. values: [count, width]. Throws Error if count is 0, since an accessor cannot be
// empty.
template <class T>
int AddValues(GlbDocument& document, View<const T> values, int width, GlbUse use);

// [count, width] of an accessor; `field` names the reference to it in errors. Throws Error if there
// is no such accessor, its component type or width differs, or (floats) a value is not finite.
template <class T>
std::vector<T> ReadValues(const GlbDocument& document,
                          int accessor,
                          int width,
                          const std::string& field);

// Atomic. Throws Error if the file would exceed GLB's 4 GiB.
void WriteGlb(const GlbDocument& document);

// Reads only this file. Throws Error for a URI, within or outside it, for any problem that CheckGlb
// finds, and for an extension that the file requires and `known_extensions` lacks.
GlbDocument ReadGlb(const std::string& path, const std::vector<std::string>& known_extensions);
// The same for a file's bytes; `path` is for errors.
GlbDocument ParseGlb(const std::string& path,
                     const std::vector<char>& bytes,
                     const std::vector<std::string>& known_extensions);

// Rejects .glb files that a glTF library could misread or be exploited by. Checks the container
// (magic, version 2, every length against the file's), the JSON (syntax, nesting) and that, in the
// JSON,
// - no buffer or image has a URI, and no extension outside `known_extensions` is required;
// - every buffer view lies within the binary chunk, every accessor within its buffer view, aligned
//   and not sparse; all their numbers are non-negative integers.
// Throws Error naming the field and its value.
void CheckGlb(const std::string& path,
              const std::vector<char>& bytes,
              const std::vector<std::string>& known_extensions);

}  // namespace cosplat
