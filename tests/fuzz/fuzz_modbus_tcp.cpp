// Modbus/TCP on both sides: headers, requests as a server reads them, replies as a client does.
#include <cstdlib>

#include "emulators/robotiq/gripper_registers.hpp"
#include "hardware/robotiq/gripper_words.hpp"
#include "protocol/modbus_frame.hpp"
#include "rooms.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;
using namespace stonestack::protocol::modbus;

void check(bool held) {
  if (!held) std::abort();
}

void try_pdu(View pdu) {
  const auto parsed = parse_request(pdu);
  if (const auto* request = std::get_if<Request>(&parsed)) {
    const Bytes again = request_pdu(*request);
    check(Bytes(pdu.begin(), pdu.end()) == again);
    check(request->address + request->count <= 0x10000);
    check(first_written(*request) + request->values.size() <= 0x10000);
    check(reads(*request) || writes(*request));
  }
  for (const auto function : {kReadHolding, kReadInput, kWriteOne, kWriteMany, kReadWriteMany}) {
    const Request asked{function, 2000, static_cast<std::uint16_t>(function == kWriteOne ? 1 : 8),
                        std::vector<std::uint16_t>(function == kWriteOne ? 1 : 8)};
    const Reply reply = parse_reply(asked, pdu);
    if (reply.kind == Reply::Kind::kDone && reads(asked)) {
      check(reply.registers.size() == 8);
      const ThreeFingerStatus status = decode_gripper_status(reply.registers);
      check(status.axes[0].position >= 0 && status.axes[0].position <= 255);
      static_cast<void>(gripper_fault_text(status.fault));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const View bytes(data, size);
  try_pdu(bytes);
  IdealGripperPlant plant;
  GripperRegisters registers(plant);
  for (std::size_t at = 0; at + kTcpHeader <= size;) {
    const auto header = parse_tcp_header(bytes.subspan(at));
    if (!header) break;
    const std::size_t length = header->length - 1U;
    if (at + kTcpHeader + length > size) break;
    const View pdu = bytes.subspan(at + kTcpHeader, length);
    try_pdu(pdu);
    const Bytes frame = tcp_frame(header->transaction, header->unit, pdu);
    check(View(frame).size() == kTcpHeader + length);
    const auto parsed = parse_request(pdu);
    const auto* request = std::get_if<Request>(&parsed);
    if (request != nullptr && writes(*request) && first_written(*request) + request->values.size() <= 8)
      registers.write(first_written(*request), request->values);
    registers.advance(0.05);
    static_cast<void>(registers.status());
    at += kTcpHeader + length;
  }
  return 0;
}
