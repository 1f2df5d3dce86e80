#include "splat/io/glb.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are stored as glTF has them");

template <class T>
constexpr int kComponent = std::is_same_v<T, float>      ? kGlbFloat
                           : std::is_same_v<T, int16_t>  ? kGlbInt16
                           : std::is_same_v<T, uint32_t> ? kGlbUint32
                                                         : kGlbUint8;

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

}  // namespace

// Begins at a multiple of 4 bytes, which the largest component type needs.
template <class T>
int AddValues(GlbDocument& document, View<const T> values, int width, GlbUse use) {
  const size_t numbers = values.size();
  if (numbers == 0 || numbers % width != 0)
    throw Error(document.path,
                "accessors[" + std::to_string(document.accessors.size()) + "]",
                "has " + std::to_string(numbers) + " numbers, expected a positive multiple of " +
                    std::to_string(width));
  document.binary.resize((document.binary.size() + 3) / 4 * 4);
  document.accessors.push_back(
      {kComponent<T>, width, numbers / width, document.binary.size(), sizeof(T) * width, use});
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data);
  document.binary.insert(document.binary.end(), bytes, bytes + sizeof(T) * numbers);
  return int(document.accessors.size()) - 1;
}

template <class T>
std::vector<T> ReadValues(const GlbDocument& document,
                          int accessor,
                          int width,
                          const std::string& field) {
  const GlbAccessor& found = Find(document, accessor, kComponent<T>, width, field);
  std::vector<T> values(found.count * width);
  for (size_t i = 0; i < found.count; ++i)
    std::memcpy(
        &values[i * width], &document.binary[found.offset + i * found.stride], width * sizeof(T));
  if constexpr (std::is_same_v<T, float>)
    for (size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        throw Error(
            document.path, field, Format("element {} is not finite ({})", i / width, values[i]));
  return values;
}

template int AddValues(GlbDocument&, View<const float>, int, GlbUse);
template int AddValues(GlbDocument&, View<const int16_t>, int, GlbUse);
template int AddValues(GlbDocument&, View<const uint32_t>, int, GlbUse);
template int AddValues(GlbDocument&, View<const char>, int, GlbUse);
template std::vector<float> ReadValues(const GlbDocument&, int, int, const std::string&);
template std::vector<int16_t> ReadValues(const GlbDocument&, int, int, const std::string&);
template std::vector<uint32_t> ReadValues(const GlbDocument&, int, int, const std::string&);
template std::vector<char> ReadValues(const GlbDocument&, int, int, const std::string&);

}  // namespace cosplat
