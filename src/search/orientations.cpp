#include "search/orientations.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::search {

std::vector<Eigen::Matrix3d> orientations(const OrientationOptions& options) {
  constexpr double kGoldenAngle = 2.399963229728653;
  const double min_cosine = std::cos(std::min(options.max_tilt, 3.14159265358979));
  const double share = std::clamp((1.0 - min_cosine) / 2.0, 1.0 / 6.0, 1.0);
  const int count = static_cast<int>(std::ceil(options.directions / share));
  // The lattice's pole is the stone's present up axis, so that leaving a stone as it lies is nearly tried.
  const Eigen::Quaterniond from_pole =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), options.up_O.normalized());
  std::vector<Eigen::Matrix3d> list;
  for (int k = 0; k < count; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / count;
    if (z < min_cosine) break;
    const double r = std::sqrt(1.0 - z * z), angle = kGoldenAngle * k;
    const Eigen::Vector3d up_O = from_pole * Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z);
    list.push_back(Eigen::Quaterniond::FromTwoVectors(up_O, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  }
  return list;
}

Eigen::Matrix3d yaw_rotation(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace stonestack::search
