#include "geometry/pose_yaml.hpp"

#include <cmath>

namespace stonestack::geometry {

Pose read_pose(yaml::Map map) {
  constexpr double kFarthest = 100.0;  // m
  const Eigen::Vector3d p(map.number("x", -kFarthest, kFarthest), map.number("y", -kFarthest, kFarthest),
                          map.number("z", -kFarthest, kFarthest));
  const Eigen::Quaterniond q(map.number("qw", -2, 2), map.number("qx", -2, 2), map.number("qy", -2, 2),
                             map.number("qz", -2, 2));
  map.finish();
  if (std::abs(q.norm() - 1.0) > 0.01)
    map.fail("q", concat("has length ", q.norm()), "a rotation has length 1");
  return make_pose(p, q);
}

}  // namespace stonestack::geometry
