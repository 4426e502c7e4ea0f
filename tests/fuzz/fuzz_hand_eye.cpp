// Files of a calibration: refused with a FileError, or valid poses; what an easy_handeye file held is the
// same when it is written and read again.
#include <algorithm>

#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/hand_eye.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("calibration.yaml", fuzz::text_of(data, size));
  try {
    for (const auto& pair : read_hand_eye_pairs(path).pairs)
      check(is_valid(pair.T_R_F) && is_valid(pair.T_C_B));
  } catch (const FileError&) {
  }
  EasyHandEye read;
  try {
    read = read_easy_handeye(path);
  } catch (const FileError&) {
    return 0;
  }
  check(is_valid(read.T_A_C));
  write_easy_handeye(path, read);
  EasyHandEye again = read_easy_handeye(path);
  const auto by_key = [](const auto& a, const auto& b) { return a.key < b.key; };
  std::sort(read.parameters.begin(), read.parameters.end(), by_key);
  std::sort(again.parameters.begin(), again.parameters.end(), by_key);
  check(again.parameters == read.parameters && again.mount == read.mount && again.of_ros2 == read.of_ros2);
  check((again.T_A_C.matrix() - read.T_A_C.matrix()).cwiseAbs().maxCoeff() < 1e-12);
  return 0;
}
