// The simulated controller's side of RTDE on arbitrary bytes: whole or byte by byte, the answers are the
// same.
#include <cstdlib>

#include "simulation/ur/rtde_server_session.hpp"

namespace {

using namespace stonestack;

std::string answers(std::string_view bytes, std::size_t piece) {
  static const RobotModel robot = read_robot("ur10");
  IdealPlant plant(Joints::Zero());
  UrController controller(UrServerOptions(), robot, plant);
  InputOwners owners;
  RtdeServerSession session(1, controller, owners);
  std::string all;
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    for (const auto& reply : session.feed(bytes.substr(at, piece))) all += reply;
  controller.step();
  if (session.broken() && session.started() && all.empty()) std::abort();
  return all + session.sample().value_or("");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (answers(bytes, size + 1) != answers(bytes, 1)) std::abort();
  return 0;
}
