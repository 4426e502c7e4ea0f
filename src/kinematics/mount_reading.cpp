#include "kinematics/mount_reading.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kInFront = 0.02;         // m, that a camera may stand in front of the finger tips
constexpr double kSamePlace = 0.02;       // m, between mounts that are as good as one
constexpr double kSameAttitude = 0.10;    // rad
constexpr double kGrazing = 0.1;          // cosine: the optical axis hardly meets the table
constexpr double kMetresARadian = 0.385;  // m: weighs tilt against height as kGoodTable does

bool is_within(const TableOffset& table, const TableOffset& limit) {
  return std::abs(table.height) <= limit.height && table.tilt <= limit.tilt;
}

double size_of(const TableOffset& table) {
  return std::hypot(table.height, kMetresARadian * table.tilt);
}

bool is_same(const Pose& a, const Pose& b) {
  const PoseDifference off = difference(a, b);
  return off.translation < kSamePlace && off.angle < kSameAttitude;
}

MountFit fit_of(MountReading reading, const Pose& numbers, const Pose& T_F_T, const Pose& T_W_T,
                const Plane& table_C) {
  const Pose T_T_C = mount_of(reading, numbers, T_F_T);
  return {reading, T_T_C, table_offset(T_T_C, T_W_T, table_C)};
}

}  // namespace

std::string to_text(MountReading reading) {
  switch (reading) {
    case MountReading::kTip:
      return "T_T_C, the camera in the finger tips";
    case MountReading::kTipInverse:
      return "T_C_T, the finger tips in the camera (the inverse)";
    case MountReading::kFlange:
      return "T_F_C, the camera in the flange";
    case MountReading::kFlangeInverse:
      return "T_C_F, the flange in the camera (the inverse)";
  }
  return "unknown";
}

Pose mount_of(MountReading reading, const Pose& numbers, const Pose& T_F_T) {
  switch (reading) {
    case MountReading::kTip:
      return numbers;
    case MountReading::kTipInverse:
      return numbers.inverse();
    case MountReading::kFlange:
      return T_F_T.inverse() * numbers;
    case MountReading::kFlangeInverse:
      return T_F_T.inverse() * numbers.inverse();
  }
  return numbers;
}

bool is_possible_mount(const Pose& T_T_C) {
  return T_T_C.translation().z() <= kInFront && T_T_C.linear()(2, 2) > 0.0;
}

TableOffset table_offset(const Pose& T_T_C, const Pose& T_W_T, const Plane& table_C) {
  require(std::abs(table_C.normal.norm() - 1.0) < 1e-6, "the table's normal has the length ",
          table_C.normal.norm());
  const double slope = table_C.normal.z();
  const Eigen::Vector3d p_C = std::abs(slope) > kGrazing ? Eigen::Vector3d(0, 0, table_C.offset / slope)
                                                         : Eigen::Vector3d(table_C.offset * table_C.normal);
  const Pose T_W_C = T_W_T * T_T_C;
  const double up = (T_W_C.linear() * table_C.normal).z();
  return {(T_W_C * p_C).z(), std::acos(std::clamp(up, -1.0, 1.0))};
}

MountCheck check_mount(const Pose& numbers, MountReading meant, const Pose& T_F_T, const Pose& T_W_T,
                       const Plane& table_C) {
  require(is_valid(numbers) && is_valid(T_F_T) && is_valid(T_W_T), "a mount is compared by rigid transforms");
  MountCheck check;
  check.meant = fit_of(meant, numbers, T_F_T, T_W_T, table_C);
  for (const MountReading reading : kMountReadings) {
    const MountFit fit = fit_of(reading, numbers, T_F_T, T_W_T, table_C);
    if (reading != meant && is_possible_mount(fit.T_T_C) && is_within(fit.table, kGoodTable) &&
        !is_same(fit.T_T_C, check.meant.T_T_C))
      check.others.push_back(fit);
  }
  std::stable_sort(check.others.begin(), check.others.end(),
                   [](const MountFit& a, const MountFit& b) { return size_of(a.table) < size_of(b.table); });
  if (is_within(check.meant.table, kGoodTable))
    check.verdict = check.others.empty() ? MountCheck::Verdict::kFits : MountCheck::Verdict::kAmbiguous;
  else if (!check.others.empty())
    check.verdict = MountCheck::Verdict::kOther;
  else if (is_within(check.meant.table, kRoughTable))
    check.verdict = MountCheck::Verdict::kRough;
  return check;
}

}  // namespace stonestack::kinematics
