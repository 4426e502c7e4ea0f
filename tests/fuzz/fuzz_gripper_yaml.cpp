// A gripper's file: refused with a FileError, or a gripper that can be planned with.
#include "fuzz/checks.hpp"
#include "kinematics/gripper_file.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("gripper.yaml", fuzz::text_of(data, size));
  try {
    const GripperFile file = read_gripper_file(path);
    check(file.against == 1 || file.against == 2);
    check(file.min_object < file.max_opening && file.min_force < file.max_force &&
          file.min_speed < file.max_speed);
    check(file.open_count < file.closed_count && file.mass > 0 && file.tip > file.pad_length);
    check(!file.boxes.empty() && file.boxes.size() <= 16);
    for (const GripperFileBox& box : file.boxes) check(box.size.minCoeff() > 0 && box.p_T_centre.allFinite());
    for (std::size_t i = 1; i < file.tips.size(); ++i) check(file.tips[i].opening > file.tips[i - 1].opening);
  } catch (const FileError&) {
  }
  return 0;
}
