#include "stonestack/hardware/cell_file.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/constants.hpp"
#include "core/yaml.hpp"
#include "hardware/cell_config.hpp"
#include "hardware/constants.hpp"

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

/// `name`: of the group of three ranges.
std::optional<Eigen::AlignedBox3d> read_box(const std::array<std::string, 3>& ranges, const std::string& name,
                                            const std::string& path) {
  Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(-kFarthest), Eigen::Vector3d::Constant(kFarthest));
  bool any = false;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::string& text = ranges[static_cast<std::size_t>(i)];
    if (text.empty()) continue;
    any = true;
    const std::string where = concat("limits.", name, ".", kAxes[i]);
    const Range range = read_range(yaml::parse(text, path), path, where);
    if (range.min < -kFarthest || range.max > kFarthest)
      throw FileError(path, concat(where, " is [", range.min, ", ", range.max, "] m"),
                      concat("metres within ", kFarthest, " of the origin are meant"));
    box.min()[i] = range.min;
    box.max()[i] = range.max;
  }
  return any ? std::optional(box) : std::nullopt;
}

/// Corners of palm, sensor and coupling, in F. Fingers and camera stand out further; plans count on them.
std::vector<Eigen::Vector3d> mounted_corners(const Pose& T_F_T) {
  std::vector<Eigen::Vector3d> p_F;
  for (const double x : {-kMountedHalfWidth, kMountedHalfWidth})
    for (const double y : {-kMountedHalfWidth, kMountedHalfWidth}) {
      p_F.push_back(T_F_T * Eigen::Vector3d(x, y, -kMountedFront));
      p_F.emplace_back(x, y, 0.0);
    }
  p_F.push_back(T_F_T.translation());
  return p_F;
}

ArmFence read_fence(const Eigen::AlignedBox3d& box, const Pose& T_W_R, const Pose& T_F_T,
                    const std::string& path) {
  const Eigen::Vector3d base = T_W_R.translation();
  for (Eigen::Index i = 0; i < 3; ++i)
    if (base[i] < box.min()[i] || base[i] > box.max()[i])
      throw FileError(path,
                      concat("limits.fence.", kAxes[i], " is [", box.min()[i], ", ", box.max()[i],
                             "] m, and the robot's base stands outside, at ", base[i], " m"),
                      "write a range that holds the whole arm, or limits.workspace for the tip of the tool");
  return {box, T_W_R, mounted_corners(T_F_T)};
}

}  // namespace

FieldList fields(CellLimits& l) {
  constexpr FieldRange kShare{0.01, 1.0};
  FieldList list{
      user(field("joints", l.joints,
                 "six of [least, most], degrees, base to wrist 3; within the robot's own")),
      user(field("joint_speed", l.joint_speed, kShare, "", "share of the robot's own limits")),
      field("joint_acceleration", l.joint_acceleration, kShare, "", "share of the robot's own limits"),
      user(field("tool_speed", l.tool_speed, {0.02, 5.0}, "m/s", "of the tool tip at most")),
  };
  for (std::size_t i = 0; i < 3; ++i)
    list.push_back(user(field(concat("workspace.", kAxes[i]), l.workspace[i],
                              "[least, most] of the tool tip in the world, m")));
  for (std::size_t i = 0; i < 3; ++i)
    list.push_back(user(field(concat("fence.", kAxes[i]), l.fence[i],
                              "[least, most] of the whole arm and gripper in the world, m")));
  return list;
}

RobotModel limit_robot(RobotModel robot, const CellLimits& limits, const Pose& T_W_R, const Pose& T_F_T,
                       const std::string& path) {
  if (!limits.joints.empty()) limit_joints(robot, limits.joints, path);
  robot.velocity *= limits.joint_speed;
  robot.acceleration *= limits.joint_acceleration;
  robot.tool_speed = limits.tool_speed;
  if (const auto box = read_box(limits.workspace, "workspace", path))
    robot.workspace = ToolWorkspace{*box, T_W_R, T_F_T};
  if (const auto box = read_box(limits.fence, "fence", path))
    robot.fence = read_fence(*box, T_W_R, T_F_T, path);
  return robot;
}

}  // namespace stonestack::hardware
