#include <map>
#include <mutex>

#include "kinematics/gripper_file.hpp"
#include "motion/collision/gripper_linkage.hpp"

namespace stonestack::motion {
namespace {

GripperModel model_of(const GripperFile& file) {
  GripperModel gripper;
  gripper.name = file.name;
  gripper.against = file.against;
  gripper.tip = file.tip;
  gripper.max_opening = file.max_opening;
  gripper.min_object = file.min_object;
  gripper.finger_width = file.finger_width;
  gripper.finger_spacing = file.finger_spacing;
  gripper.narrow_spacing = file.narrow_spacing;
  gripper.pad_length = file.pad_length;
  gripper.force = file.grip_force;
  gripper.min_force = file.min_force;
  gripper.max_force = file.max_force;
  gripper.min_speed = file.min_speed;
  gripper.max_speed = file.max_speed;
  gripper.friction = file.friction;
  gripper.pad_thickness = file.pad_thickness;
  gripper.pad_stiffness = file.pad_stiffness;
  gripper.pad_shear = file.pad_shear;
  gripper.mass = file.mass;
  gripper.centre_of_mass = file.centre_of_mass;
  gripper.payload = file.payload;
  for (const GripperFileBox& box : file.boxes)
    gripper.boxes.push_back({box.size, box.p_T_centre, box.finger_side, box.spread, box.camera, box.advance});
  for (const GripperFileTip& tip : file.tips) gripper.tips.push_back({tip.opening, tip.advance});
  return gripper;
}

}  // namespace

GripperModel read_gripper(const std::string& name_or_path, Linkage linkage) {
  static std::mutex mutex;
  static std::map<std::string, GripperModel> known;  // a plan asks for its gripper again and again
  const std::lock_guard lock(mutex);
  auto found = known.find(name_or_path);
  if (found == known.end())
    found = known.emplace(name_or_path, model_of(read_gripper_file(name_or_path))).first;
  return draw_linkage(found->second, linkage);
}

std::vector<std::string> gripper_names() {
  return gripper_file_names();
}

}  // namespace stonestack::motion
