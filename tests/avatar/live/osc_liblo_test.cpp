// Our reader of OSC against liblo's writer.
#include <gtest/gtest.h>
#include <lo/lo.h>

#include <memory>
#include <type_traits>

#include "avatar/live/osc.h"

namespace cosplat {
namespace {

std::string Serialised(lo_message message, const char* path) {
  std::string bytes(lo_message_length(message, path), '\0');
  lo_message_serialise(message, path, bytes.data(), nullptr);
  return bytes;
}

TEST(OscOfLiblo, Messages) {
  // A pointer to void before liblo 0.32, to a struct since.
  using Message = std::remove_pointer_t<lo_message>;
  const std::unique_ptr<Message, decltype(&lo_message_free)> message(lo_message_new(),
                                                                     lo_message_free);
  const std::string name = "browInnerUp";
  lo_message_add(message.get(), "sfidhTFNc", name.c_str(), 0.25f, -3, 1e-3, int64_t(1) << 40, 'c');
  lo_blob blob = lo_blob_new(3, "abc");
  lo_message_add_blob(message.get(), blob);
  lo_blob_free(blob);
  lo_message_add_float(message.get(), 2.0f);
  const std::string packet = Serialised(message.get(), "/VMC/Ext/Blend/Val");
  std::vector<OscMessage> messages;
  ParseOsc(packet, messages);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].problem, "");
  EXPECT_EQ(messages[0].address, "/VMC/Ext/Blend/Val");
  const auto& arguments = messages[0].arguments;
  ASSERT_EQ(arguments.size(), 11u);
  EXPECT_EQ(arguments[0].text, name);
  EXPECT_EQ(arguments[1].number, 0.25);
  EXPECT_EQ(arguments[2].number, -3);
  EXPECT_EQ(arguments[3].number, 1e-3);
  EXPECT_EQ(arguments[4].number, double(int64_t(1) << 40));
  EXPECT_EQ(arguments[10].number, 2);
}

TEST(OscOfLiblo, Bundles) {
  lo_bundle inner = lo_bundle_new(LO_TT_IMMEDIATE);
  lo_bundle outer = lo_bundle_new(LO_TT_IMMEDIATE);
  lo_message message = lo_message_new();
  lo_message_add_int32(message, 5);
  lo_bundle_add_message(inner, "/inner", message);
  lo_bundle_add_message(outer, "/outer", message);
  lo_bundle_add_bundle(outer, inner);
  std::string packet(lo_bundle_length(outer), '\0');
  lo_bundle_serialise(outer, packet.data(), nullptr);
  lo_bundle_free_recursive(outer);
  std::vector<OscMessage> messages;
  ParseOsc(packet, messages);
  ASSERT_EQ(messages.size(), 2u);
  for (const OscMessage& each : messages) EXPECT_EQ(each.problem, "");
  EXPECT_EQ(messages[0].address, "/outer");
  EXPECT_EQ(messages[1].address, "/inner");
  EXPECT_EQ(messages[1].arguments[0].number, 5);
}

}  // namespace
}  // namespace cosplat
