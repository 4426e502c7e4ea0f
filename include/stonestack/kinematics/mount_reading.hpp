#pragma once
#include <array>
#include <string>
#include <vector>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

/// A pose of the camera on the hand, by the two frames that it may connect. Files rarely say which.
enum class MountReading {
  kTip,            ///< T_T_C: camera in the finger tips
  kTipInverse,     ///< T_C_T
  kFlange,         ///< T_F_C: camera in the flange, the result of a hand-eye calibration
  kFlangeInverse,  ///< T_C_F
};
inline constexpr std::array<MountReading, 4> kMountReadings{
    MountReading::kTip, MountReading::kTipInverse, MountReading::kFlange, MountReading::kFlangeInverse};
/// "T_C_T, the finger tips in the camera"
[[nodiscard]] std::string to_text(MountReading reading);
/// T_T_C, if `numbers` are the pose that `reading` says.
[[nodiscard]] Pose mount_of(MountReading reading, const Pose& numbers, const Pose& T_F_T);
/// The camera is not in front of the finger tips and faces the direction in which the hand points.
[[nodiscard]] bool is_possible_mount(const Pose& T_T_C);

/// Where a mount puts the table that the camera sees. W has the table at z = 0.
struct TableOffset {
  double height = 0.0;  ///< z in W (m) of the point where the optical axis meets the table
  double tilt = 0.0;    ///< angle (rad) between the table's normal and z of W
};
[[nodiscard]] TableOffset table_offset(const Pose& T_T_C, const Pose& T_W_T, const Plane& table_C);

/// One reading of the numbers, compared with the view.
struct MountFit {
  MountReading reading = MountReading::kTip;
  Pose T_T_C = Pose::Identity();
  TableOffset table;
};

/// Result of `check_mount`.
struct MountCheck {
  enum class Verdict {
    kFits,       ///< the table is where it should be
    kRough,      ///< nearly: `kRoughTable`
    kAmbiguous,  ///< the table is where it should be, also with `others`, which are another place
    kOther,      ///< the numbers are what one of `others` says, not what was meant
    kNone,       ///< no reading explains what the camera sees
  };
  Verdict verdict = Verdict::kNone;
  MountFit meant;
  std::vector<MountFit> others;  ///< possible mounts that put the table where it should be, best first
};

/// Height and tilt of the table that a good calibration explains: twice what a hand-eye error of 0.5 deg does
/// half a metre away.
inline constexpr TableOffset kGoodTable{0.010, 0.026};
/// Up to here the numbers are those of this mount, and worth a new calibration.
inline constexpr TableOffset kRoughTable{0.025, 0.070};

/// Compares `numbers`, which are meant as `meant`, with one view of the table, and finds out what else they
/// may be. `T_W_T` is the tool when the view was taken. A view of a plane shows height and tilt of the
/// camera, not its place along the table.
[[nodiscard]] MountCheck check_mount(const Pose& numbers, MountReading meant, const Pose& T_F_T,
                                     const Pose& T_W_T, const Plane& table_C);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
