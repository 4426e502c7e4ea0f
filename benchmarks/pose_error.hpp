#pragma once
#include <optional>
#include <vector>

#include "rooms.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/mesh.hpp"

/// How far an estimated pose of a possibly symmetric object is off, as the BOP toolkit counts it (Hodan et
/// al., BOP Challenge 2020 on 6D Object Localization, section 2.2; bop_toolkit_lib/pose_error.py and
/// misc.py).
namespace stonestack::bench {

/// A rotation by any angle about the line through `p_O` along `n_O` (unit) leaves the object as it is.
struct AxisOfSymmetry {
  Eigen::Vector3d n_O = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
};

/// All motions in O that leave the object as it is, the identity first: the discrete ones, each followed by
/// the turns about every axis in steps of at most 1.2 degrees (BOP's 1 % of the diameter).
[[nodiscard]] std::vector<Pose> symmetries(const std::vector<Pose>& discrete,
                                           const std::vector<AxisOfSymmetry>& axes);

/// An object with what scoring its poses needs.
struct ScoredObject {
  Mesh mesh;                          ///< in O, metres
  double diameter = 0.0;              ///< largest distance of two of its points, m
  std::vector<Pose> symmetries;       ///< with the identity; empty: unknown
  std::vector<Eigen::Vector3d> hull;  ///< vertices of the convex hull
};
/// Without `symmetries` they are unknown; without `diameter` (m) it is measured.
[[nodiscard]] ScoredObject make_scored_object(const Mesh& mesh, std::optional<std::vector<Pose>> symmetries,
                                              std::optional<double> diameter);

/// Maximum symmetry-aware surface distance, m: the largest distance of a point at both poses, for the
/// symmetry that makes it smallest.
[[nodiscard]] double mssd(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true);
/// Maximum symmetry-aware projection distance, pixels: the same in the image. Infinite for a pose behind the
/// camera.
[[nodiscard]] double mspd(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true,
                          const CameraIntrinsics& camera);
/// ADD-S (also ADI), m: the mean distance from a point at the estimated pose to the nearest point at the true
/// one.
[[nodiscard]] double add_s(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true);
/// Of the symmetries, the one that makes the angle smallest.
[[nodiscard]] PoseDifference symmetric_difference(const ScoredObject& object, const Pose& T_C_O,
                                                  const Pose& T_C_O_true);

}  // namespace stonestack::bench
