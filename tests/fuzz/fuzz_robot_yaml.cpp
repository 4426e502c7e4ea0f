// What was measured on one robot: refused with a FileError, or a robot that still is one.
#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("robot.yaml", fuzz::text_of(data, size));
  try {
    const RobotModel robot = read_robot(path);
    fuzz::check(robot.payload > 0 && robot.acceleration.minCoeff() > 0);
    fuzz::check(is_valid(forward(robot, Joints::Constant(0.3))));
  } catch (const FileError&) {
  }
  return 0;
}
