#pragma once
#include <nlohmann/json.hpp>

#include "stonestack/geometry/pose.hpp"

/// Private to the library and the command: a pose as every JSON output writes it.
namespace stonestack::geometry {

/// {x, y, z, qx, qy, qz, qw} with qw >= 0; metres.
[[nodiscard]] inline nlohmann::json pose_json(const Pose& pose) {
  Eigen::Quaterniond q(pose.linear());
  if (q.w() < 0) q.coeffs() *= -1;
  const Eigen::Vector3d& p = pose.translation();
  return {{"x", p.x()},  {"y", p.y()},  {"z", p.z()}, {"qx", q.x()},
          {"qy", q.y()}, {"qz", q.z()}, {"qw", q.w()}};
}

}  // namespace stonestack::geometry
