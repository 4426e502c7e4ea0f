// Every decoder of RTDE on arbitrary bytes. What decodes must encode to bytes that decode to the same.
#include <cstdlib>

#include "protocol/rtde_wire.hpp"
#include "rooms.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

void check(bool held) {
  if (!held) std::abort();
}

void try_packet(const RtdePacket& packet) {
  static_cast<void>(decode_protocol_request(packet));
  static_cast<void>(decode_accepted(packet, RtdeKind::kStart));
  static_cast<void>(decode_control_version(packet));
  static_cast<void>(decode_input_setup(packet));
  for (const int protocol : {1, 2}) {
    static_cast<void>(decode_setup_reply(packet, RtdeKind::kSetupOutputs, protocol));
    static_cast<void>(decode_setup_reply(packet, RtdeKind::kSetupInputs, protocol));
    if (const auto text = decode_text(packet, protocol)) {
      const auto again = decode_text(encode_text(*text, protocol), protocol);
      check(again && again->level == text->level && again->source == text->source);
      check(protocol == 1 || again->message == text->message);
    }
    if (const auto setup = decode_output_setup(packet, protocol)) {
      for (const auto& name : setup->names) static_cast<void>(find_rtde_output(name));
      const auto again = decode_output_setup(encode_output_setup(*setup, protocol), protocol);
      check(again.has_value());
    }
    const std::vector<RtdeType> types = {RtdeType::kDouble, RtdeType::kVector6d, RtdeType::kBool};
    if (const auto data = decode_data(packet, types, protocol, true))
      check(encode_data(*data, protocol, true).payload.size() == packet.payload.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  RtdeStream whole, cut;
  whole.feed(bytes);
  std::size_t packets = 0, packets_cut = 0;
  while (const auto packet = whole.next()) {
    ++packets;
    try_packet(*packet);
    check(encode(*packet).size() == packet->payload.size() + 3);
  }
  for (const char byte : bytes) {
    cut.feed({&byte, 1});
    while (cut.next()) ++packets_cut;
  }
  check(packets == packets_cut && whole.problem() == cut.problem());
  return 0;
}
