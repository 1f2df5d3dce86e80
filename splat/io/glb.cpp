#include "splat/io/glb.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are stored as glTF has them");

// Begins at a multiple of 4 bytes, which the largest component type needs.
template <class T>
int AddValues(GlbDocument& document, View<const T> values, const GlbAccessor& accessor) {
  const size_t numbers = values.size();
  if (numbers == 0 || numbers % accessor.width != 0)
    throw Error(document.path,
                "accessors[" + std::to_string(document.accessors.size()) + "]",
                "has " + std::to_string(numbers) + " numbers, expected a positive multiple of " +
                    std::to_string(accessor.width));
  document.binary.resize((document.binary.size() + 3) / 4 * 4);
  GlbAccessor added = accessor;
  added.count = numbers / accessor.width;
  added.offset = document.binary.size();
  added.stride = sizeof(T) * accessor.width;
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data);
  document.binary.insert(document.binary.end(), bytes, bytes + sizeof(T) * numbers);
  document.accessors.push_back(added);
  return int(document.accessors.size()) - 1;
}

// The accessor; throws Error unless it has this component type and width.
const GlbAccessor& Find(
    const GlbDocument& document, int accessor, int component, int width, const std::string& field) {
  if (accessor < 0 || size_t(accessor) >= document.accessors.size())
    throw Error(document.path,
                field,
                "refers to accessor " + std::to_string(accessor) + ", but there are only " +
                    std::to_string(document.accessors.size()));
  const GlbAccessor& found = document.accessors[accessor];
  if (found.component != component || found.width != width)
    throw Error(document.path,
                field,
                "accessor " + std::to_string(accessor) + " has component type " +
                    std::to_string(found.component) + " and " + std::to_string(found.width) +
                    " numbers per element, expected " + std::to_string(component) + " and " +
                    std::to_string(width));
  return found;
}

template <class T>
std::vector<T> Copy(const GlbDocument& document, const GlbAccessor& accessor) {
  std::vector<T> values(accessor.count * accessor.width);
  for (size_t i = 0; i < accessor.count; ++i)
    std::memcpy(&values[i * accessor.width],
                &document.binary[accessor.offset + i * accessor.stride],
                accessor.width * sizeof(T));
  return values;
}

}  // namespace

int AddFloats(GlbDocument& document, View<const float> values, int width, GlbUse use) {
  return AddValues(document, values, {kGlbFloat, width, 0, 0, 0, use});
}

int AddShorts(GlbDocument& document, View<const int16_t> values, GlbUse use) {
  return AddValues(document, values, {kGlbInt16, 1, 0, 0, 0, use});
}

int AddUnsigned(GlbDocument& document, View<const uint32_t> values, GlbUse use) {
  return AddValues(document, values, {kGlbUint32, 1, 0, 0, 0, use});
}

int AddBytes(GlbDocument& document, View<const char> values, GlbUse use) {
  return AddValues(document, values, {kGlbUint8, 1, 0, 0, 0, use});
}

std::vector<float> ReadFloats(const GlbDocument& document,
                              int accessor,
                              int width,
                              const std::string& field) {
  auto values = Copy<float>(document, Find(document, accessor, kGlbFloat, width, field));
  for (size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(
          document.path, field, Format("element {} is not finite ({})", i / width, values[i]));
  return values;
}

std::vector<int16_t> ReadShorts(const GlbDocument& document,
                                int accessor,
                                const std::string& field) {
  return Copy<int16_t>(document, Find(document, accessor, kGlbInt16, 1, field));
}

std::vector<uint32_t> ReadUnsigned(const GlbDocument& document,
                                   int accessor,
                                   const std::string& field) {
  return Copy<uint32_t>(document, Find(document, accessor, kGlbUint32, 1, field));
}

std::vector<char> ReadBytes(const GlbDocument& document, int accessor, const std::string& field) {
  return Copy<char>(document, Find(document, accessor, kGlbUint8, 1, field));
}

}  // namespace cosplat
