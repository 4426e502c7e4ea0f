// The primary port's stream on arbitrary bytes, whole and byte by byte; what decodes must survive encoding.
#include <cstdlib>

#include "protocol/primary_wire.hpp"
#include "rooms.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  PrimaryStream whole, cut;
  whole.feed(bytes);
  long messages = 0, messages_cut = 0;
  while (const auto message = whole.next()) {
    ++messages;
    PrimaryStream again;
    again.feed(encode(*message));
    const auto copy = again.next();
    if (!copy || copy->kind != message->kind || copy->code != message->code || copy->line != message->line)
      std::abort();
  }
  for (const char byte : bytes) {
    cut.feed({&byte, 1});
    while (cut.next()) ++messages_cut;
  }
  if (messages != messages_cut || whole.problem() != cut.problem()) std::abort();
  return 0;
}
