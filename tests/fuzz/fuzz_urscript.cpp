// The URScript compiler and machine on arbitrary text: errors are answers, loops end, memory stays bounded.
#include <cstdlib>

#include "simulation/ur/controller.hpp"
#include "simulation/ur/script_collector.hpp"

namespace {

using namespace stonestack;

const RobotModel& robot() {
  static const RobotModel model = read_robot("ur10");
  return model;
}

void run(const std::string& source) {
  Joints q;
  q << 0.1, -1.3, 1.6, -1.8, -1.5, 0.2;
  IdealPlant plant(q);
  UrController controller(UrServerOptions(), robot(), plant);
  controller.run_script(source);
  for (int k = 0; k < 60; ++k) {
    controller.step();
    if (!controller.plant().q.allFinite()) std::abort();
    for (const auto& event : controller.take_events())
      if (event.kind == ControllerEvent::Kind::kRuntimeException && event.line < 0) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  run(text);
  ScriptCollector whole, cut;
  const auto scripts = whole.feed(text);
  std::vector<std::string> pieces;
  for (const char byte : text)
    for (auto& script : cut.feed({&byte, 1})) pieces.push_back(std::move(script));
  if (scripts != pieces) std::abort();
  for (const auto& script : scripts) run(script);
  return 0;
}
