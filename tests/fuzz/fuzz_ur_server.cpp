// The simulated controller's side of RTDE and Dashboard on arbitrary bytes: never a crash, every RTDE reply a
// sound packet, every Dashboard answer one printable line. The first byte chooses the port.
#include <cstdint>
#include <cstdlib>
#include <sstream>

#include "emulators/ur/dashboard_session.hpp"
#include "emulators/ur/rtde_session.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "rooms.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

void check(bool held) {
  if (!held) std::abort();
}

void talk_rtde(UrController& controller, std::string_view bytes) {
  InputOwners owners;
  RtdeStream heard(65535);
  {
    RtdeSession session(1, controller, owners);
    for (std::size_t at = 0; at < bytes.size() && !session.broken(); at += 64) {
      for (const auto& reply : session.feed(bytes.substr(at, 64))) heard.feed(reply);
      controller.step();
      if (const auto sample = session.sample()) heard.feed(*sample);
    }
    while (heard.next()) continue;
    check(heard.problem().empty());
  }
  check(owners.empty());
}

void talk_dashboard(UrController& controller, std::string_view bytes) {
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    const auto answer = answer_dashboard(controller, line);
    check(!answer.line.empty() && answer.line.find('\n') == std::string::npos);
    controller.step();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RobotModel robot = read_robot("ur10");
  if (size == 0) return 0;
  IdealPlant plant(Joints::Constant(0.5));
  UrController controller(UrServerOptions{}, robot, plant);
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0)
    talk_rtde(controller, bytes);
  else
    talk_dashboard(controller, bytes);
  return 0;
}
