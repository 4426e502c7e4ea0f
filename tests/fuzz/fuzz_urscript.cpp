// A script port's text, whatever it is: cut into programs, compiled, and run for a few control steps.
#include <cstdint>
#include <cstdlib>

#include "emulators/ur/controller.hpp"
#include "rooms.hpp"
#include "urscript/script_collector.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

constexpr int kSteps = 12;
constexpr std::size_t kMaxPrograms = 8;

Joints start() {
  Joints q;
  q << 0.1, -1.3, 1.6, -1.8, -1.5, 0.2;
  return q;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RobotModel robot = read_robot("ur10");
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  ScriptCollector collector;
  auto programs = collector.feed(bytes);
  if (collector.inside_program()) programs.push_back(collector.give_up());
  if (programs.size() > kMaxPrograms) programs.resize(kMaxPrograms);
  IdealPlant plant(start());
  UrServerOptions options;
  options.version = size % 2 == 0 ? "3.15.8.106339" : "5.23.0.1";
  UrController controller(options, robot, plant);
  for (const auto& program : programs) {
    controller.run_script(program);
    for (int k = 0; k < kSteps; ++k) controller.step();
    if (!controller.plant().q.allFinite()) std::abort();
  }
  return 0;
}
