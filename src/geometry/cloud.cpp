#include "stonestack/geometry/cloud.hpp"

namespace stonestack::geometry {

Cloud transformed(const Cloud& cloud, const Pose& T_B_A) {
  Cloud result = cloud;
  for (Eigen::Vector3f& point : result.points) point = (T_B_A * point.cast<double>()).cast<float>();
  for (Eigen::Vector3f& normal : result.normals)
    normal = (T_B_A.linear() * normal.cast<double>()).cast<float>();
  return result;
}

Cloud without_gaps(const Cloud& cloud) {
  Cloud result;
  result.points.reserve(cloud.points.size());
  result.normals.reserve(cloud.normals.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite()) continue;
    result.points.push_back(cloud.points[i]);
    if (!cloud.normals.empty()) result.normals.push_back(cloud.normals[i]);
  }
  result.width = static_cast<int>(result.points.size());
  result.height = 1;
  return result;
}

}  // namespace stonestack::geometry
