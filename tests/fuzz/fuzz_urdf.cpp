// Robot descriptions: refused with a FileError, or joints with limits and shapes that are finite, and a DH
// table that gives a pose.
#include "fuzz/checks.hpp"
#include "kinematics/dh.hpp"
#include "kinematics/urdf.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Links that form a loop hold one another by shared_ptr inside urdfdom 3.0, and stay when it then refuses
/// the file: LeakSanitizer asks for this.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:liburdfdom_model";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  try {
    RobotModel robot = parse_urdf(fuzz::text_of(data, size), "fuzz.urdf");
    check((robot.lower.array() < robot.upper.array()).all());
    check(robot.velocity.allFinite() && robot.velocity.minCoeff() > 0);
    for (const auto& capsule : robot.capsules)
      check(capsule.a.allFinite() && capsule.b.allFinite() && capsule.radius >= 0 && capsule.link <= 6);
    if (!derive_dh(robot).empty()) return 0;
    check(is_valid(forward(robot, Joints::Constant(0.3))));
  } catch (const FileError&) {
  }
  return 0;
}
