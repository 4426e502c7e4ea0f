#include "stonestack/hardware/cell_file.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/constants.hpp"
#include "core/yaml.hpp"
#include "hardware/cell_config.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kLimitsRounding = 1e-3;  // deg: a turn as 6.28318 rad is one
constexpr double kFarthest = 10.0;        // m, more than any of these robots reaches
constexpr const char* kAxes[] = {"x", "y", "z"};

struct Range {
  double min, max;
};

/// [least, most] as a file has it.
Range read_range(const YAML::Node& node, const std::string& path, const std::string& where) {
  if (!node.IsSequence() || node.size() != 2)
    throw FileError(path, where + " is not a pair of numbers", "write it as [least, most]");
  Range range{};
  for (std::size_t i = 0; i < 2; ++i) {
    double& value = i == 0 ? range.min : range.max;
    if (!node[i].IsScalar() || !YAML::convert<double>::decode(node[i], value) || !std::isfinite(value))
      throw FileError(path, concat(where, "[", i, "] is not a finite number"), "write it as [least, most]");
  }
  if (!(range.min < range.max))
    throw FileError(path, concat(where, " is [", range.min, ", ", range.max, "], which leaves nothing"),
                    "write the smaller number first");
  return range;
}

void limit_joints(RobotModel& robot, const std::string& text, const std::string& path) {
  const YAML::Node list = yaml::parse(text, path);
  if (!list.IsSequence() || list.size() != 6)
    throw FileError(path, "limits.joints does not name six joints", "write six of [least, most], in degrees");
  for (Eigen::Index j = 0; j < 6; ++j) {
    const std::string where = concat("limits.joints[", j, "]");
    const Range range = read_range(list[static_cast<std::size_t>(j)], path, where);
    const double min = robot.lower[j] / kDegree, max = robot.upper[j] / kDegree;
    if (range.min < min - kLimitsRounding || range.max > max + kLimitsRounding)
      throw FileError(path,
                      concat(where, " is [", range.min, ", ", range.max,
                             "] deg, wider than the robot's own, ", min, " to ", max, " deg"),
                      "write what lies within, or leave limits.joints out");
    robot.lower[j] = std::max(robot.lower[j], range.min * kDegree);
    robot.upper[j] = std::min(robot.upper[j], range.max * kDegree);
  }
}

std::optional<Eigen::AlignedBox3d> read_workspace(const CellLimits& limits, const std::string& path) {
  Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(-kFarthest), Eigen::Vector3d::Constant(kFarthest));
  bool any = false;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::string& text = limits.workspace[static_cast<std::size_t>(i)];
    if (text.empty()) continue;
    any = true;
    const std::string where = concat("limits.workspace.", kAxes[i]);
    const Range range = read_range(yaml::parse(text, path), path, where);
    if (range.min < -kFarthest || range.max > kFarthest)
      throw FileError(path, concat(where, " is [", range.min, ", ", range.max, "] m"),
                      concat("metres within ", kFarthest, " of the origin are meant"));
    box.min()[i] = range.min;
    box.max()[i] = range.max;
  }
  return any ? std::optional(box) : std::nullopt;
}

}  // namespace

FieldList fields(CellLimits& l) {
  constexpr FieldRange kShare{0.01, 1.0};
  FieldList list{
      user(field("joints", l.joints,
                 "six of [least, most], degrees, base to wrist 3; within the robot's own")),
      user(field("joint_speed", l.joint_speed, kShare, "", "share of the robot's own limits")),
      user(field("joint_acceleration", l.joint_acceleration, kShare, "", "share of the robot's own limits")),
  };
  for (std::size_t i = 0; i < 3; ++i)
    list.push_back(user(field(concat("workspace.", kAxes[i]), l.workspace[i],
                              "[least, most] of the tool tip in the world, m")));
  return list;
}

RobotModel limit_robot(RobotModel robot, const CellLimits& limits, const Pose& T_W_R, const Pose& T_F_T,
                       const std::string& path) {
  if (!limits.joints.empty()) limit_joints(robot, limits.joints, path);
  robot.velocity *= limits.joint_speed;
  robot.acceleration *= limits.joint_acceleration;
  if (const auto box = read_workspace(limits, path)) robot.workspace = ToolWorkspace{*box, T_W_R, T_F_T};
  return robot;
}

}  // namespace stonestack::hardware
