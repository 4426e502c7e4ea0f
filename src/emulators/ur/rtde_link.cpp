#include "emulators/ur/server_links.hpp"

namespace stonestack::emulators {
namespace {

constexpr int kOutOfStepAfter = 10;  // data packages

}  // namespace

RtdeLink::RtdeLink(TcpStream stream, UrController& controller, InputOwners& owners, int number)
    : ServerLink(std::move(stream), controller), session_(number, controller, owners) {}

void RtdeLink::receive(std::string_view bytes) {
  std::string replies;
  for (const auto& reply : session_.feed(bytes)) replies += reply;
  send(replies);
  if (session_.broken()) close();
}

void RtdeLink::after_step() {
  auto sample = session_.sample();
  if (!sample) return;
  if (controller().faults.out_of_step && ++packages_ == kOutOfStepAfter) (*sample)[1] = '\2';
  offer(*sample);
}

}  // namespace stonestack::emulators
