#pragma once
#include <array>
#include <memory>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// How grasps of a stone are sampled and judged. Values without a source are design choices.
struct GraspOptions {
  int directions = 400;        ///< approach directions over the sphere (about 10 deg apart)
  int yaws = 12;               ///< turns about the approach, each direction
  double spacing = 0.008;      ///< between surface points that stand for the scan [m]
  double shallowest = -0.004;  ///< finger tips past the centre of mass, least [m]
  double deepest = 0.028;      ///< most [m]
  int depths = 5;              ///< steps between the two
  double sideways = 0.012;     ///< the gripper shifted along y by +- this where the middle gives nothing [m]
  double pad_softness = 0.0015;  ///< surface that deep under a pad counts as touched [m]
  double unequal = 0.003;        ///< [m] most that finger B meets the stone before finger C (a stone turns by
                                 ///< that over the finger spacing when it is squeezed)
  double finger_clearance = 0.012;  ///< between each open pad and the stone on approach [m]
  double palm_clearance = 0.005;    ///< between palm and stone [m]
  double friction_share = 0.8;      ///< of the pad friction that the squeeze alone may use
  double force_factor = 2.0;        ///< grip force over what friction needs
  /// Unit vector, frame O: only approaches within `cone` (rad) of it are sampled. Zero: all.
  Eigen::Vector3d n_O_towards = Eigen::Vector3d::Zero();
  double cone = 0.7;
  double narrow_score = 0.4;  ///< of a grasp's score when fingers B and C are drawn together: they hold
                              ///< less against turning, so they are taken where little else serves
};
[[nodiscard]] FieldList fields(GraspOptions& options);

/// A pinch between finger A and fingers B and C, or B alone. Frame T: origin midway between the pads at the
/// height of the finger tips when fully open, x the closing direction towards A, z out of the gripper. At
/// other openings the tips stand at z = `tip_advance`.
struct Grasp {
  Pose T_O_T = Pose::Identity();
  double opening = 0.0;      ///< between the pads when closed [m]
  double pre_opening = 0.0;  ///< on approach and after release [m]
  double spacing = 0.0;      ///< of fingers B and C [m]; 0: there is no C
  /// Contacts with A first: middles of the touched surface, and their mean outward unit normals. Three
  /// fingers have one each. A pad against a pad has one for each half that touches, so that it resists
  /// turning.
  std::array<Eigen::Vector3d, 4> p_O_contact{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                             Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::array<Eigen::Vector3d, 4> n_O_contact = p_O_contact;
  int contacts = 3;  ///< of these four
  int on_a = 1;      ///< of these, on finger A
  /// Force [N] at finger A per N of weight that pulls along +x, -x, +y, -y, +z, -z of T: least that friction
  /// needs.
  std::array<double, 6> force_per_weight{};
  double score = 0.0;  ///< in [0, 1], larger is better: normals along the closing axis, B and C touching
                       ///< together, centre of mass between the pads, little force
};
/// Least force at finger A (N) that holds `weight` (N) with gravity along the unit vector `n_T_down`.
/// An upper bound: forces for the three axes add up.
[[nodiscard]] double holding_force(const Grasp& grasp, double weight, const Eigen::Vector3d& n_T_down);

/// Grasps that sampling found, best first, and how many samples fell to which test (the first that refused).
struct GraspSet {
  std::vector<Grasp> grasps;
  int tried = 0;
  int too_wide = 0;    ///< stone between the pads wider than the gripper opens, or narrower than it closes
  int no_contact = 0;  ///< a pad meets nothing, or B and C not together
  int gripper_in_stone = 0;  ///< palm or upper finger would touch the stone first
  int slips = 0;             ///< a squeeze is not in the friction cones
  int too_heavy = 0;         ///< needs more force than the gripper has, whatever the orientation
  double narrowest = 0.0;    ///< least width that was met between pads [m]; 0: none met
};
/// Samples grasps over the whole stone. Deterministic. Contacts come from the scan.
///
/// Fingers B and C are `finger_spacing` apart, or drawn together to `narrow_spacing`: that gripper is 62 mm
/// smaller across and comes nearer to the table at a tilt. Both fingers must touch, so a stone has to be
/// about 50 mm long across the closing direction, or 30 mm. One finger against one holds what is as long as a
/// pad is wide. Throws InvalidArgument for a stone without scan or mass.
[[nodiscard]] GraspSet grasp_candidates(const Stone& stone, const GripperModel& gripper,
                                        const GraspOptions& options = {});
/// The grasps of both, best first, and their counts together.
[[nodiscard]] GraspSet joined(const GraspSet& a, const GraspSet& b);
/// Candidates made once for each stone, gripper and options as long as they are held or among those used
/// last.
[[nodiscard]] std::shared_ptr<const GraspSet> cached_grasps(const Stone& stone, const GripperModel& gripper,
                                                            const GraspOptions& options = {});

}  // namespace stonestack::motion
