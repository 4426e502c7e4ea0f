#include "stonestack/kinematics/robot_model.hpp"

#include <algorithm>
#include <filesystem>

#include "kinematics/dh.hpp"
#include "kinematics/urdf.hpp"
#include "stonestack/core/data.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/options.hpp"

namespace stonestack {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kLargestUrdf = std::size_t{1} << 20;

bool is_path(const std::string& text) {
  return text.find('/') != std::string::npos || fs::path(text).extension() == ".urdf";
}

fs::path urdf_path(const std::string& name_or_path) {
  if (is_path(name_or_path)) return name_or_path;
  try {
    return data_path("robots/" + name_or_path + ".urdf");
  } catch (const FileError&) {
    std::string known;
    for (const auto& name : robot_names()) known += (known.empty() ? "" : ", ") + name;
    throw FileError("robot '" + name_or_path + "'", "is not known",
                    known.empty() ? "set STONESTACK_DATA to the folder that holds robots/"
                                  : "use " + known + " or the path of a URDF");
  }
}

/// What a URDF has no place for, from the YAML of the same name beside it.
void read_extras(const fs::path& urdf, RobotModel& robot) {
  fs::path yaml = urdf;
  yaml.replace_extension(".yaml");
  std::error_code ignored;
  if (!fs::exists(yaml, ignored)) return;
  double acceleration = robot.acceleration[0];
  read_fields({field("payload", robot.payload, {0.1, 200.0}, "kg", "data sheet"),
               field("acceleration", acceleration, {0.01, 100.0}, "rad/s^2", "facts: not public")},
              yaml.string());
  robot.acceleration.setConstant(acceleration);
}

}  // namespace

RobotModel read_robot(const std::string& name_or_path) {
  const fs::path path = urdf_path(name_or_path);
  RobotModel robot = parse_urdf(read_file(path.string(), kLargestUrdf), path.string());
  if (const auto reason = derive_dh(robot); !reason.empty())
    throw FileError(path.string(), "is not a robot with UR kinematics: " + reason,
                    "use a UR or a chain like it");
  read_extras(path, robot);
  return robot;
}

std::vector<std::string> robot_names() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(data_path("robots"), ignored))
    if (entry.path().extension() == ".urdf") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace stonestack
