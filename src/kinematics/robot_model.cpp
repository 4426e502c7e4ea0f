#include "stonestack/kinematics/robot_model.hpp"

#include <algorithm>
#include <filesystem>

#include "kinematics/calibration.hpp"
#include "kinematics/dh.hpp"
#include "kinematics/urdf.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/options.hpp"

namespace stonestack::kinematics {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxUrdf = std::size_t{1} << 20;

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
                                  : "use " + known + " or the path of a URDF or YAML");
  }
}

/// Reads what a URDF has no place for, and what was measured on one robot.
void read_extras(const fs::path& yaml, RobotModel& robot, FieldList more) {
  double acceleration = robot.acceleration[0];
  const Calibration nominal = nominal_calibration(robot);
  Calibration measured = nominal;
  read_fields(join({{field("payload", robot.payload, {0.1, 200.0}, "kg", "data sheet"),
                     field("acceleration", acceleration, {0.01, 100.0}, "rad/s^2", "UR states none")},
                    fields(measured),
                    std::move(more)}),
              yaml.string());
  robot.acceleration.setConstant(acceleration);
  if (const auto reason = calibrate(robot, nominal, measured); !reason.empty())
    throw FileError(yaml.string(), "is no calibration of this robot: " + reason,
                    "give the rows of the controller's DH table, or the output of ur_calibration");
}

bool is_yaml(const std::string& text) {
  const auto extension = fs::path(text).extension();
  return extension == ".yaml" || extension == ".yml";
}

/// A YAML that names a robot and how this one differs.
RobotModel read_own_robot(const std::string& path) {
  std::string base;
  Calibration ignored;
  double number = 0.0;
  const FieldList named{field("robot", base, "name or URDF")};
  read_fields(named, path,
              join({{field("payload", number, {0.1, 200.0}, "kg", ""),
                     field("acceleration", number, {0.01, 100.0}, "rad/s^2", "")},
                    fields(ignored)}));
  if (base.empty() || is_yaml(base))
    throw FileError(path, "does not name its robot", "add a line robot: ur10, or the path of a URDF");
  if (is_path(base)) base = (fs::path(path).parent_path() / base).string();  // an absolute one stays
  RobotModel robot = read_robot(base);
  read_extras(path, robot, named);
  return robot;
}

}  // namespace

RobotModel read_robot(const std::string& name_or_path) {
  if (is_yaml(name_or_path)) return read_own_robot(name_or_path);
  const fs::path path = urdf_path(name_or_path);
  RobotModel robot = parse_urdf(read_file(path.string(), kMaxUrdf), path.string());
  if (const auto reason = derive_dh(robot); !reason.empty())
    throw FileError(path.string(), "is not a robot with UR kinematics: " + reason,
                    "use a UR or a chain like it");
  fs::path yaml = path;
  yaml.replace_extension(".yaml");
  std::error_code ignored;
  if (fs::exists(yaml, ignored)) read_extras(yaml, robot, {});
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

}  // namespace stonestack::kinematics
