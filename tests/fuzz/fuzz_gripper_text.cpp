// What a client of the URCap's text socket makes of arbitrary answers, and what the simulated gripper makes
// of arbitrary lines.
#include <sstream>

#include "emulators/robotiq/two_finger_registers.hpp"
#include "fuzz/checks.hpp"
#include "protocol/gripper_text.hpp"
#include "rooms.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const GripperFile file = read_gripper_file("robotiq-2f-85");
  IdealGripperPlant plant({file.open_count, file.closed_count, 137.0, 0.15});
  TwoFingerRegisters gripper(plant, file);
  std::istringstream lines(fuzz::text_of(data, size));
  int count = 0;
  for (std::string line; count < 200 && std::getline(lines, line); ++count) {
    for (const char* variable : {"POS", "STA", "ACT"})
      if (const auto value = parse_gripper_answer(line, variable)) check(*value >= 0 && *value <= 255);
    if (is_gripper_ack(line)) check(is_gripper_text(line));
    if (const auto parsed = parse_gripper_line(line); parsed && !parsed->set.empty())
      check(parse_gripper_line(set_text(parsed->set)).has_value());
    const std::string answer = gripper.answer(line);
    check(is_gripper_text(answer) && !answer.empty());
    const std::string bare = gripper.bare_answer(line);
    check(is_gripper_text(bare) && !bare.empty());
    gripper.advance(0.05);
    check((gripper.status()[2] >> 8U) <= 255U);
  }
  return 0;
}
