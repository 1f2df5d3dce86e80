#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/io/glb.h"

namespace cosplat {
namespace {

constexpr size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr size_t kMax = std::numeric_limits<uint32_t>::max();

// Our files nest 9 levels deep. Parsers recurse once per level, so that a malicious file could
// overflow their stack.
constexpr int kMaxNesting = 64;

struct Chunks {
  std::string_view json;
  size_t binary_size = 0;
};

uint32_t NumberAt(const std::vector<char>& bytes, size_t offset) {
  uint32_t number;
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

Chunks SplitChunks(const std::string& path, const std::vector<char>& bytes) {
  if (bytes.size() < kHeaderBytes + kChunkHeaderBytes || NumberAt(bytes, 0) != kMagic)
    throw Error(path, "is not a binary glTF file (.glb)");
  if (NumberAt(bytes, 4) != 2)
    throw Error(path, "version", Format("is {}, expected binary glTF 2", NumberAt(bytes, 4)));
  if (NumberAt(bytes, 8) != bytes.size())
    throw Error(path,
                "length",
                "is " + std::to_string(NumberAt(bytes, 8)) + " in the header, the file has " +
                    std::to_string(bytes.size()) + " bytes");
  Chunks chunks;
  size_t index = 0;
  for (size_t at = kHeaderBytes; at < bytes.size(); ++index) {
    const std::string field = "chunk " + std::to_string(index);
    const size_t left = bytes.size() - at;
    if (left < kChunkHeaderBytes) throw Error(path, field, "is cut off");
    const size_t size = NumberAt(bytes, at);
    const uint32_t type = NumberAt(bytes, at + 4);
    if (size > left - kChunkHeaderBytes || size % 4 != 0)
      throw Error(path,
                  field,
                  "has length " + std::to_string(size) + ", expected a multiple of 4 up to " +
                      std::to_string(left - kChunkHeaderBytes));
    at += kChunkHeaderBytes;
    if ((index == 0) != (type == kJsonChunk))
      throw Error(path, field, "expected JSON in chunk 0 and nowhere else");
    if (index == 0) chunks.json = {bytes.data() + at, size};
    if (index == 1 && type == kBinaryChunk) chunks.binary_size = size;
    at += size;
  }
  return chunks;
}

void CheckNesting(const std::string& path, std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string) {
      depth += (c == '{' || c == '[') - (c == '}' || c == ']');
      if (depth > kMaxNesting)
        throw Error(path, "JSON", "is nested more than " + std::to_string(kMaxNesting) + " deep");
    }
  }
}

Json Parse(const std::string& path, std::string_view text) {
  CheckNesting(path, text);
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    throw Error(path, "JSON", error.what());
  }
}

// A member that must be an integer in [least, most], written as an integer.
size_t Whole(const JsonField& object, const std::string& key, size_t min, size_t max) {
  const JsonField field = object[key];
  field.Number();
  if (!field.raw().is_number_unsigned() || field.raw().get<uint64_t>() < min ||
      field.raw().get<uint64_t>() > max)
    field.Fail("is " + field.raw().dump() + ", expected a whole number from " +
               std::to_string(min) + " to " + std::to_string(max));
  return field.raw().get<size_t>();
}

size_t WholeOrZero(const JsonField& object, const std::string& key, size_t max) {
  return object.Has(key) ? Whole(object, key, 0, max) : 0;
}

// Calls `check` with each element of an array that may be absent.
template <class F>
void ForEach(const JsonField& object, const std::string& key, const F& check) {
  if (!object.Has(key)) return;
  const JsonField array = object[key];
  for (size_t i = 0; i < array.size(); ++i) check(array[i]);
}

void RefuseUri(const JsonField& object) {
  if (!object.Has("uri")) return;
  const JsonField uri = object["uri"];
  constexpr size_t kShown = 60;
  uri.Fail("is " + uri.raw().dump().substr(0, kShown) + ", only data inside the file is read");
}

size_t CheckBuffers(const JsonField& root, size_t binary_size) {
  size_t length = 0;
  ForEach(root, "buffers", [&](const JsonField& buffer) {
    RefuseUri(buffer);
    if (length > 0) buffer.Fail("is a second buffer, expected only one");
    length = Whole(buffer, "byteLength", 1, binary_size);
  });
  return length;
}

struct BufferView {
  size_t offset, length, stride;
};

BufferView CheckBufferView(const JsonField& field, size_t buffer_length) {
  Whole(field, "buffer", 0, 0);
  BufferView view;
  view.offset = WholeOrZero(field, "byteOffset", buffer_length);
  view.length = Whole(field, "byteLength", 1, buffer_length - view.offset);
  view.stride = 0;
  if (field.Has("byteStride")) {
    view.stride = Whole(field, "byteStride", 4, 252);
    if (view.stride % 4 != 0)
      field["byteStride"].Fail("is " + std::to_string(view.stride) + ", expected a multiple of 4");
  }
  return view;
}

size_t ComponentBytes(const JsonField& accessor) {
  switch (Whole(accessor, "componentType", 0, kMax)) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      accessor["componentType"].Fail("is " + accessor["componentType"].raw().dump() +
                                     ", expected 5120 to 5123, 5125 or 5126");
  }
}

size_t Width(const JsonField& accessor) {
  constexpr std::array<const char*, 4> kTypes{"SCALAR", "VEC2", "VEC3", "VEC4"};
  const JsonField type = accessor["type"];
  const auto found = std::find(kTypes.begin(), kTypes.end(), type.String());
  if (found == kTypes.end())
    type.Fail("is " + type.raw().dump() + ", expected SCALAR, VEC2, VEC3 or VEC4");
  return 1 + size_t(found - kTypes.begin());
}

void CheckAccessor(const JsonField& field, const std::vector<BufferView>& views) {
  if (field.Has("sparse")) field["sparse"].Fail("sparse accessors are not supported");
  if (views.empty()) field.Fail("there are no bufferViews");
  const BufferView& view = views[Whole(field, "bufferView", 0, views.size() - 1)];
  const size_t component = ComponentBytes(field), element = component * Width(field);
  const size_t stride = view.stride > 0 ? view.stride : element;
  if (stride < element) field.Fail(Format("has elements of {} bytes every {}", element, stride));
  const size_t offset = WholeOrZero(field, "byteOffset", view.length);
  if ((view.offset + offset) % component != 0) field.Fail("is not aligned to its components");
  const size_t count = Whole(field, "count", 1, kMax);
  const size_t end = offset + (count - 1) * stride + element;
  if (end > view.length)
    throw Error(field.file(),
                field.path() + ".count",
                "is " + std::to_string(count) + ": that takes " + std::to_string(end) +
                    " bytes of a buffer view of " + std::to_string(view.length));
}

void CheckRequiredExtensions(const JsonField& root, const std::vector<std::string>& known) {
  ForEach(root, "extensionsRequired", [&](const JsonField& extension) {
    if (std::find(known.begin(), known.end(), extension.String()) != known.end()) return;
    extension.Fail("is " + extension.raw().dump() + ", which is not supported");
  });
}

}  // namespace

void CheckGlb(const std::string& path,
              const std::vector<char>& bytes,
              const std::vector<std::string>& known_extensions) {
  const Chunks chunks = SplitChunks(path, bytes);
  const Json json = Parse(path, chunks.json);
  const JsonField root(path, json);
  const JsonField version = root["asset"]["version"];
  if (!version.String().starts_with("2."))
    throw Error(path, version.path(), "is " + version.raw().dump() + ", expected 2.0");
  CheckRequiredExtensions(root, known_extensions);
  ForEach(root, "images", RefuseUri);
  const size_t buffer_length = CheckBuffers(root, chunks.binary_size);
  std::vector<BufferView> views;
  ForEach(root, "bufferViews", [&](const JsonField& field) {
    views.push_back(CheckBufferView(field, buffer_length));
  });
  ForEach(root, "accessors", [&](const JsonField& field) { CheckAccessor(field, views); });
}

}  // namespace cosplat
