#include "motion/collision/mounted_gripper.hpp"

#include <algorithm>

namespace stonestack::motion {
namespace {

constexpr double kUpright = 1e-6;  // of 1 - cos of the tilt
constexpr double kThin = 1e-6;     // m, of rounding

}  // namespace

GripperModel mounted_at(GripperModel gripper, const Pose& T_F_T) {
  if (T_F_T.rotation()(2, 2) < 1.0 - kUpright) return gripper;
  const double flange = -T_F_T.translation().z();  // z in T
  const auto is_fixed = [](const GripperBox& box) { return box.finger_side == 0.0 && !box.camera; };
  const auto is_behind = [&](const GripperBox& box) {
    return is_fixed(box) && box.p_T_centre.z() + 0.5 * box.size.z() < flange + kThin;
  };
  gripper.boxes.erase(std::remove_if(gripper.boxes.begin(), gripper.boxes.end(), is_behind),
                      gripper.boxes.end());
  for (GripperBox& box : gripper.boxes) {
    const double back = box.p_T_centre.z() - 0.5 * box.size.z();
    if (!is_fixed(box) || back > flange - kThin) continue;
    box.size.z() -= flange - back;
    box.p_T_centre.z() += 0.5 * (flange - back);
  }
  return gripper;
}

}  // namespace stonestack::motion
