// A .glb file taken apart and put together again, to see what a reader says of a changed one.
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

namespace cosplat::test {

struct GlbBytes {
  nlohmann::json json;
  std::string binary;
};

inline uint32_t Number32(const std::string& bytes, size_t at) {
  uint32_t number;
  std::memcpy(&number, bytes.data() + at, sizeof(number));
  return number;
}
inline std::string Bytes32(uint32_t number) {
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

// Of a valid file with a binary chunk.
inline GlbBytes SplitGlb(const std::string& bytes) {
  const size_t json_size = Number32(bytes, 12);
  return {nlohmann::json::parse(bytes.substr(20, json_size)), bytes.substr(28 + json_size)};
}

inline std::string JoinGlb(std::string json, const std::string& binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  return "glTF" + Bytes32(2) + Bytes32(uint32_t(28 + json.size() + binary.size())) +
         Bytes32(uint32_t(json.size())) + "JSON" + json + Bytes32(uint32_t(binary.size())) +
         std::string("BIN\0", 4) + binary;
}
inline std::string JoinGlb(const GlbBytes& glb) { return JoinGlb(glb.json.dump(), glb.binary); }

}  // namespace cosplat::test
