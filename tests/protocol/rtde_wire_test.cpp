#include "protocol/rtde_wire.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "protocol/hex.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

using hardware::hex;
using testing::ElementsAre;

/// The one packet in these bytes.
RtdePacket packet(std::string_view spelled) {
  RtdeStream stream;
  stream.feed(hex(spelled));
  auto found = stream.next();
  EXPECT_TRUE(found) << stream.problem();
  EXPECT_FALSE(stream.next());
  return found.value_or(RtdePacket{});
}

// Frames below are written by hand from UR's RTDE guide.

TEST(RtdeWire, ProtocolVersion) {
  EXPECT_EQ(encode(encode_protocol_request(2)), hex("00 05 56 00 02"));
  EXPECT_EQ(decode_protocol_request(packet("00 05 56 00 01")), 1);
  EXPECT_FALSE(decode_protocol_request(packet("00 04 56 01")));
  EXPECT_EQ(encode(encode_accepted(RtdeKind::kProtocolVersion, true)), hex("00 04 56 01"));
  EXPECT_EQ(decode_accepted(packet("00 04 56 00"), RtdeKind::kProtocolVersion), false);
  EXPECT_FALSE(decode_accepted(packet("00 04 56 00"), RtdeKind::kStart));
  EXPECT_FALSE(decode_accepted(packet("00 03 53"), RtdeKind::kStart));
}

TEST(RtdeWire, ControlVersion) {
  const UrVersion version{3, 15, 8, 106339};
  const auto bytes = hex("00 13 76 00 00 00 03 00 00 00 0F 00 00 00 08 00 01 9F 63");
  EXPECT_EQ(encode(encode_control_version(version)), bytes);
  EXPECT_EQ(encode({RtdeKind::kControlVersion, {}}), hex("00 03 76"));
  EXPECT_EQ(decode_control_version(packet("00 13 76 00000003 0000000F 00000008 00019F63")), version);
  EXPECT_FALSE(decode_control_version(packet("00 0F 76 00000003 0000000F 00000008")));
  EXPECT_EQ(to_string(version), "3.15.8.106339");
}

TEST(RtdeWire, StartAndPause) {
  EXPECT_EQ(encode({RtdeKind::kStart, {}}), hex("00 03 53"));
  EXPECT_EQ(encode({RtdeKind::kPause, {}}), hex("00 03 50"));
  EXPECT_EQ(decode_accepted(packet("00 04 53 01"), RtdeKind::kStart), true);
}

TEST(RtdeWire, TextInBothProtocols) {
  const RtdeText text{"Hi", "RTDE", RtdeText::Level::kWarning};
  EXPECT_EQ(encode(encode_text(text, 2)), hex("00 0C 4D 02 'Hi' 04 'RTDE' 02"));
  EXPECT_EQ(encode(encode_text(text, 1)), hex("00 06 4D 02 'Hi'"));
  const auto two = decode_text(packet("00 0C 4D 02 'Hi' 04 'RTDE' 01"), 2);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->message, "Hi");
  EXPECT_EQ(two->source, "RTDE");
  EXPECT_EQ(two->level, RtdeText::Level::kError);
  const auto one = decode_text(packet("00 06 4D 00 'Hi'"), 1);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->message, "Hi");
  EXPECT_EQ(one->level, RtdeText::Level::kException);
  EXPECT_FALSE(decode_text(packet("00 06 4D 20 'Hi'"), 2)) << "the length byte points past the end";
}

TEST(RtdeWire, OutputSetup) {
  EXPECT_EQ(encode(encode_output_setup({{"timestamp", "actual_q"}, 125.0}, 2)),
            hex("00 1D 4F 40 5F 40 00 00 00 00 00 'timestamp,actual_q'"));
  EXPECT_EQ(encode(encode_output_setup({{"timestamp"}, 125.0}, 1)), hex("00 0C 4F 'timestamp'"));
  const auto setup = decode_output_setup(packet("00 0F 4F 40 7F 40 00 00 00 00 00 'a,b,'"), 2);
  ASSERT_TRUE(setup);
  EXPECT_EQ(setup->frequency, 500.0);
  EXPECT_THAT(setup->names, ElementsAre("a", "b")) << "ur_rtde ends its list with a comma";
  EXPECT_FALSE(decode_output_setup(packet("00 0A 4F 40 7F 40 00 00 00 00"), 2));
}

TEST(RtdeWire, SetupReplies) {
  const auto out = decode_setup_reply(packet("00 13 4F 01 'DOUBLE,VECTOR6D'"), RtdeKind::kSetupOutputs, 2);
  ASSERT_TRUE(out);
  EXPECT_EQ(out->recipe, 1);
  EXPECT_THAT(out->types, ElementsAre("DOUBLE", "VECTOR6D"));
  const auto old = decode_setup_reply(packet("00 12 4F 'DOUBLE,VECTOR6D'"), RtdeKind::kSetupOutputs, 1);
  ASSERT_TRUE(old);
  EXPECT_THAT(old->types, ElementsAre("DOUBLE", "VECTOR6D"));
  const auto in = decode_setup_reply(packet("00 10 49 00 'INT32,IN_USE'"), RtdeKind::kSetupInputs, 2);
  ASSERT_TRUE(in);
  EXPECT_THAT(in->types, ElementsAre("INT32", "IN_USE"));
  EXPECT_FALSE(rtde_type("IN_USE"));
  EXPECT_EQ(encode(encode_setup_reply(RtdeKind::kSetupInputs, {1, {"INT32"}}, 1)), hex("00 09 49 01 'INT32'"))
      << "input replies carry a recipe id in both protocols";
  EXPECT_EQ(encode(encode_setup_reply(RtdeKind::kSetupOutputs, {1, {"INT32"}}, 1)), hex("00 08 4F 'INT32'"));
  EXPECT_EQ(encode(encode_input_setup({"input_int_register_24"})), hex("00 18 49 'input_int_register_24'"));
}

TEST(RtdeWire, DataFromControllerInBothProtocols) {
  const std::vector<RtdeType> types = {RtdeType::kDouble, RtdeType::kVector6d};
  const std::string values =
      "3FF0000000000000"
      "0000000000000000 3FF0000000000000 BFF0000000000000 3FE0000000000000 4000000000000000 C000000000000000";
  const std::array<double, 6> q = {0, 1, -1, 0.5, 2, -2};
  const auto two = decode_data(packet("00 3C 55 01" + values), types, 2, true);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->recipe, 1);
  EXPECT_EQ(std::get<double>(two->values[0]), 1.0);
  EXPECT_EQ((std::get<std::array<double, 6>>(two->values[1])), q);
  const auto one = decode_data(packet("00 3B 55" + values), types, 1, true);
  ASSERT_TRUE(one);
  EXPECT_EQ((std::get<std::array<double, 6>>(one->values[1])), q);
  EXPECT_FALSE(decode_data(packet("00 3B 55" + values), types, 2, true)) << "a byte short";
  EXPECT_EQ(encode(encode_data({1, {1.0, q}}, 2, true)), hex("00 3C 55 01" + values));
}

TEST(RtdeWire, DataFromClientAlwaysHasItsRecipe) {
  EXPECT_EQ(encode(encode_data({1, {std::int32_t{258}}}, 1, false)), hex("00 08 55 01 00 00 01 02"));
  EXPECT_EQ(data_recipe(packet("00 08 55 07 00 00 01 02")), 7);
  EXPECT_FALSE(data_recipe(packet("00 03 55")));
}

TEST(RtdeWire, EveryType) {
  const std::string bytes =
      "00 7E 55 09 01 FF 01020304 0102030405060708 FFFFFFFE C004000000000000"
      "3FF0000000000000 4000000000000000 4008000000000000"
      "0000000000000000 0000000000000000 0000000000000000 0000000000000000 0000000000000000 7FF0000000000000"
      "00000001 00000002 00000003 00000004 00000005 FFFFFFFF";
  const std::vector<RtdeType> types = {RtdeType::kBool,     RtdeType::kUint8,    RtdeType::kUint32,
                                       RtdeType::kUint64,   RtdeType::kInt32,    RtdeType::kDouble,
                                       RtdeType::kVector3d, RtdeType::kVector6d, RtdeType::kVector6Int32};
  const auto data = decode_data(packet(bytes), types, 2, true);
  ASSERT_TRUE(data);
  EXPECT_EQ(std::get<bool>(data->values[0]), true);
  EXPECT_EQ(std::get<std::uint8_t>(data->values[1]), 255);
  EXPECT_EQ(std::get<std::uint32_t>(data->values[2]), 0x01020304u);
  EXPECT_EQ(std::get<std::uint64_t>(data->values[3]), 0x0102030405060708u);
  EXPECT_EQ(std::get<std::int32_t>(data->values[4]), -2);
  EXPECT_EQ(std::get<double>(data->values[5]), -2.5);
  EXPECT_EQ((std::get<std::array<double, 3>>(data->values[6])), (std::array<double, 3>{1, 2, 3}));
  EXPECT_TRUE(std::isinf((std::get<std::array<double, 6>>(data->values[7])[5])));
  EXPECT_EQ((std::get<std::array<std::int32_t, 6>>(data->values[8])[5]), -1);
  EXPECT_EQ(encode(encode_data(*data, 2, true)), hex(bytes));
  const auto bits = decode_data(packet("00 1C 55 09 00000001 00000002 00000003 00000004 00000005 FFFFFFFF"),
                                {RtdeType::kVector6Uint32}, 2, true);
  ASSERT_TRUE(bits);
  EXPECT_EQ((std::get<std::array<std::uint32_t, 6>>(bits->values[0])[5]), 0xFFFFFFFFu);
}

TEST(RtdeStream, CutAtEveryByte) {
  const std::string bytes = hex("00 05 56 00 02  00 03 53  00 0C 4D 02 'Hi' 04 'RTDE' 02  00 04 53 01");
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    RtdeStream stream;
    std::vector<RtdeKind> kinds;
    for (const auto& part : {bytes.substr(0, cut), bytes.substr(cut)}) {
      stream.feed(part);
      while (const auto found = stream.next()) kinds.push_back(found->kind);
    }
    EXPECT_THAT(kinds, ElementsAre(RtdeKind::kProtocolVersion, RtdeKind::kStart, RtdeKind::kTextMessage,
                                   RtdeKind::kStart))
        << "cut at " << cut;
    EXPECT_EQ(stream.problem(), "");
  }
}

TEST(RtdeStream, ByteByByteForLong) {
  const std::string frame = hex("00 08 55 01 00 00 01 02");
  RtdeStream stream;
  int count = 0;
  for (int i = 0; i < 20000; ++i)
    for (const char byte : frame) {
      stream.feed({&byte, 1});
      while (stream.next()) ++count;
    }
  EXPECT_EQ(count, 20000);
}

TEST(RtdeStream, BreaksOnWhatCannotBeAPacket) {
  for (const char* bytes : {"00 00 55", "00 02 55", "FF FF 55", "10 01 55", "00 05 00", "00 05 7C"}) {
    RtdeStream stream;
    stream.feed(hex(bytes));
    EXPECT_FALSE(stream.next());
    EXPECT_NE(stream.problem(), "") << bytes;
    stream.feed(hex("00 04 53 01"));
    EXPECT_FALSE(stream.next()) << "a broken stream stays broken";
  }
  RtdeStream wide(65535);
  wide.feed(hex("FF FF 55"));
  EXPECT_FALSE(wide.next());
  EXPECT_EQ(wide.problem(), "");
  EXPECT_THROW(static_cast<void>(encode({RtdeKind::kTextMessage, std::string(65533, 'x')})), InvalidArgument);
}

TEST(RtdeFields, TypesAndVersions) {
  const auto type = [](const char* name) { return rtde_type_name(find_rtde_output(name)->type); };
  EXPECT_EQ(type("timestamp"), "DOUBLE");
  EXPECT_EQ(type("actual_q"), "VECTOR6D");
  EXPECT_EQ(type("payload_cog"), "VECTOR3D");
  EXPECT_EQ(type("joint_mode"), "VECTOR6INT32");
  EXPECT_EQ(type("robot_mode"), "INT32");
  EXPECT_EQ(type("safety_status_bits"), "UINT32");
  EXPECT_EQ(type("actual_digital_input_bits"), "UINT64");
  EXPECT_EQ(type("output_bit_register_64"), "BOOL");
  EXPECT_EQ(type("output_int_register_47"), "INT32");
  EXPECT_EQ(type("input_double_register_0"), "DOUBLE");
  EXPECT_EQ(find_rtde_output("output_bit_register_63"), nullptr);
  EXPECT_EQ(find_rtde_output("output_int_register_48"), nullptr);
  EXPECT_EQ(find_rtde_input("actual_q"), nullptr);
  EXPECT_EQ(find_rtde_input("speed_slider_mask")->type, RtdeType::kUint32);
  EXPECT_EQ(find_rtde_input("external_force_torque")->type, RtdeType::kVector6d);
  EXPECT_FALSE(find_rtde_output("output_int_register_24")->in({3, 8, 0, 0}));
  EXPECT_TRUE(find_rtde_output("output_int_register_24")->in({3, 9, 0, 0}));
  EXPECT_TRUE(find_rtde_output("output_int_register_23")->in({3, 3, 0, 0}));
  EXPECT_FALSE(find_rtde_output("safety_status")->in({5, 3, 0, 0}));
  EXPECT_FALSE(find_rtde_output("tcp_offset")->in({3, 12, 2, 0}));
  EXPECT_TRUE(find_rtde_output("tcp_offset")->in({5, 5, 1, 0}));
}

TEST(RtdeFields, NamesAreUniqueAndTypesRoundTrip) {
  for (const auto* list : {&rtde_outputs(), &rtde_inputs()}) {
    std::set<std::string> names;
    for (const RtdeField& field : *list) {
      EXPECT_TRUE(names.insert(field.name).second) << field.name;
      EXPECT_EQ(rtde_type(rtde_type_name(field.type)), field.type);
      EXPECT_EQ(static_cast<RtdeType>(rtde_zero(field.type).index()), field.type);
      EXPECT_EQ(encode_data({0, {rtde_zero(field.type)}}, 1, true).payload.size(), rtde_size(field.type));
    }
  }
}

}  // namespace
}  // namespace stonestack::protocol
