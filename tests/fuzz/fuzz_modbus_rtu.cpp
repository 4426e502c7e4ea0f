// Modbus RTU on both sides: a frame is found only where its CRC is right, and never beyond the bytes.
#include <cstdlib>

#include "protocol/modbus_frame.hpp"
#include "rooms.hpp"

namespace {

using namespace stonestack::protocol::modbus;

void check(bool held) {
  if (!held) std::abort();
}

void check_frame(const RtuFrame& frame, View bytes) {
  check(frame.end <= bytes.size() && frame.end >= frame.pdu.size() + 3);
  const Bytes again = rtu_frame(frame.unit, frame.pdu);
  const View there = bytes.subspan(frame.end - again.size(), again.size());
  check(Bytes(there.begin(), there.end()) == again);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  View bytes(data, size);
  for (const auto function : {kReadHolding, kReadInput, kWriteOne, kWriteMany, kReadWriteMany}) {
    const Request asked{function, 2000, static_cast<std::uint16_t>(function == kWriteOne ? 1 : 8),
                        std::vector<std::uint16_t>(function == kWriteOne ? 1 : 8)};
    if (const auto frame = find_rtu_reply(bytes, 9, asked)) {
      check_frame(*frame, bytes);
      check(frame->unit == 9 && parse_reply(asked, frame->pdu).kind != Reply::Kind::kMalformed);
    }
  }
  while (const auto frame = find_rtu_request(bytes)) {
    check_frame(*frame, bytes);
    bytes = bytes.subspan(frame->end);
  }
  static_cast<void>(hex_text(bytes));
  return 0;
}
