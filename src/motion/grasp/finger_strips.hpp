#pragma once
#include <array>
#include <span>
#include <vector>

#include "motion/grasp.hpp"

/// Private to motion: what closing fingers meet of a stone's surface.
namespace stonestack::motion {

/// z in T of what stands out furthest towards the tips beside the fingers [m].
[[nodiscard]] double palm_front(const GripperModel& gripper);

inline constexpr double kNoStone = -1e300;  ///< a height where there is nothing [m]

/// The surface from the gripper's side: points about the centre of mass in T's axes.
struct GripperView {
  Eigen::Matrix3d R_O_T;
  std::vector<Eigen::Vector3d> p_T;
  double back = 0.0;  ///< z of the point nearest to the palm [m]
};
[[nodiscard]] GripperView view_from(std::span<const SurfaceSample> surface, const Eigen::Vector3d& p_O_M,
                                    const Eigen::Matrix3d& R_O_T);

/// Profile that one finger can meet: the highest point of the stone, along x towards the finger, in each
/// slice of z.
struct FingerStrip {
  static constexpr int kSlices = 160;
  static constexpr double kPerMetre = 250.0;  ///< slices of 4 mm
  double y = 0.0;                             ///< middle of the finger [m]
  double side = 1.0;                          ///< finger at +x or -x
  std::array<double, kSlices> highest;
  std::vector<std::size_t> points;  ///< of the view, within the finger's width

  static int slice(double z);
  /// The slices of points with z between about `low` and `high`.
  static int first_slice(double low) { return slice(low + 0.5 / kPerMetre); }
  static int last_slice(double high) { return slice(high - 0.5 / kPerMetre); }
  static double middle(int slice) { return (slice + 0.5 - kSlices / 2) / kPerMetre; }  ///< its z [m]
  void add(double height, double z);
  /// Highest point with z between about `low` and `high`; kNoStone if there is none.
  [[nodiscard]] double height(double low, double high) const;
};
/// A profile for each finger: A, B and C, or A and B.
class FingerStrips {
 public:
  explicit FingerStrips(std::size_t fingers) : fingers_(fingers) {}
  [[nodiscard]] std::span<FingerStrip> all() { return {strips_.data(), fingers_}; }
  [[nodiscard]] std::span<const FingerStrip> all() const { return {strips_.data(), fingers_}; }

 private:
  std::array<FingerStrip, 3> strips_;
  std::size_t fingers_;
};
/// Cuts the profiles that the fingers can meet with the gripper shifted by `y`.
[[nodiscard]] FingerStrips cut_strips(const GripperModel& gripper, const GripperView& view, double y);
/// Where the pad of one finger stops when the finger tips are at `tip`.
[[nodiscard]] double pad_height(const GripperModel& gripper, const FingerStrip& strip, double tip);
/// Returns the heights of fingers B and C alone, the gripper not shifted: cheaper than to cut strips for it.
[[nodiscard]] std::array<double, 2> heights_of_b_and_c(const GripperModel& gripper, const GripperView& view,
                                                       double tip);

/// Contact of a pad, in O.
struct PadTouch {
  double height = kNoStone;
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), n = Eigen::Vector3d::Zero();
};
/// `softness` m: how far below the highest point the pad still touches. `view` is of that surface. `low`,
/// `high`: only what lies between them along y of T counts.
[[nodiscard]] PadTouch touched(const GripperModel& gripper, std::span<const SurfaceSample> surface,
                               double softness, const GripperView& view, const FingerStrip& strip, double tip,
                               double low = -1e300, double high = 1e300);

/// How far the gripper is turned about its approach from where two pads that face each other lie flat on the
/// stone, by the halves of each pad (rad); 0 where a half meets nothing. The gripper is not shifted.
[[nodiscard]] double turn_of_pads(const GripperModel& gripper, const GripperView& view, double tip);

}  // namespace stonestack::motion
