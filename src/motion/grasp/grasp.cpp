#include "motion/grasp.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "core/constants.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "motion/grasp/finger_strips.hpp"
#include "motion/grasp/grasp_wrench.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr int kEqualiseRounds = 4;
constexpr double kSamplesAcross = 4.0;  // of the surface, across a pad whose halves are told apart

/// Directions spread evenly over the sphere (golden spiral).
std::vector<Eigen::Vector3d> sphere_directions(int count) {
  std::vector<Eigen::Vector3d> directions;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

/// Selects the directions that the options ask for.
std::vector<Eigen::Vector3d> approaches(const GraspOptions& options) {
  std::vector<Eigen::Vector3d> directions = sphere_directions(options.directions);
  if (options.n_O_towards.isZero()) return directions;
  const double min = std::cos(options.cone);
  std::erase_if(directions, [&](const auto& z) { return z.dot(options.n_O_towards) < min; });
  return directions;
}

/// The stone's surface, once per stone, and what never changes between samples.
struct Sampler {
  const Stone& stone;
  const GripperModel gripper;  ///< at one spacing of its fingers
  GraspOptions options;
  const std::vector<SurfaceSample>& surface;
  GraspSet& set;
  double score_factor = 1.0;
  double palm_front = 0.0;  ///< z of the palm's front in T (negative) [m]
};

GripperView seen_from(const Sampler& s, const Eigen::Matrix3d& R_O_T) {
  return view_from(s.surface, s.stone.mass.p_O_M, R_O_T);
}

/// `touch`: of A, B and C, or of A and twice of B.
double score(const Sampler& s, const Grasp& grasp, const std::array<PadTouch, 3>& touch) {
  const Eigen::Vector3d x = grasp.T_O_T.linear().col(0);
  const double aligned =
      (touch[0].n.dot(x) - 0.5 * touch[1].n.dot(x) - 0.5 * touch[2].n.dot(x)) / 2;  // 1: all along x
  const double equal = 1.0 - std::abs(touch[1].height - touch[2].height) / s.options.unequal;
  const Eigen::Vector3d pinch = 0.5 * touch[0].p + 0.25 * (touch[1].p + touch[2].p);
  const double centred = std::exp(-(pinch - s.stone.mass.p_O_M).norm() / 0.03);
  const double force = *std::max_element(grasp.force_per_weight.begin(), grasp.force_per_weight.end());
  return 0.4 * std::clamp(2 * aligned - 1, 0.0, 1.0) + 0.2 * equal + 0.2 * centred +
         0.2 / std::max(1.0, force);
}

void add_contact(Grasp& grasp, const PadTouch& touch) {
  const auto i = static_cast<std::size_t>(grasp.contacts++);
  grasp.p_O_contact[i] = touch.p;
  grasp.n_O_contact[i] = touch.n;
}

/// True if the surface faces finger A where A touches, and the others where they do.
bool faces_fingers(const GraspContacts& contacts) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    const double x = contacts.n_T[i].x();
    if (i < static_cast<std::size_t>(contacts.on_a) ? x < 0.7 : x > -0.5) return false;
  }
  return true;
}

/// The contacts have been found: is it a grasp? Adds it, or counts what refused it.
void judge(Sampler& s, Grasp grasp, const std::array<PadTouch, 3>& touch) {
  const GraspContacts contacts = contacts_in_T(grasp, s.stone.mass.p_O_M);
  if (!faces_fingers(contacts) || !squeeze_holds(contacts, s.options.friction_share * s.gripper.friction)) {
    ++s.set.slips;
    return;
  }
  const auto force = force_per_weight(contacts, s.gripper.friction);
  if (!force) {
    ++s.set.slips;
    return;
  }
  grasp.force_per_weight = *force;
  const double min = *std::min_element(force->begin(), force->end());
  if (s.options.force_factor * min * s.stone.mass.mass * kGravity > s.gripper.force) {
    ++s.set.too_heavy;
    return;
  }
  grasp.score = s.score_factor * score(s, grasp, touch);
  s.set.grasps.push_back(grasp);
}

/// Heights in the axes of T about the centre of mass [m]: the stone's back, the finger tips, the origin of T.
struct GraspHeights {
  double back, tip, z;
};

/// True if the stone stands out towards a finger behind its pad: closed, or open on approach. `height`: where
/// the pad stops.
bool upper_finger_touches(const Sampler& s, const FingerStrip& strip, const GraspHeights& at,
                          const Grasp& grasp, double height) {
  const double soft = height + s.options.pad_softness, pad_back = at.tip - s.gripper.pad_length;
  if (s.gripper.linkage != Linkage::kThreeFinger) return strip.height(at.back, pad_back) > soft;
  for (int i = FingerStrip::first_slice(at.back); i <= FingerStrip::last_slice(pad_back); ++i) {
    const double z = FingerStrip::middle(i) - at.z;
    const double closed =
        finger_inside(s.gripper, grasp.opening, z) - 0.5 * grasp.opening;  // of the pad's face
    const double open = finger_inside(s.gripper, grasp.pre_opening, z) - 0.5 * grasp.opening;
    if (strip.highest[static_cast<std::size_t>(i)] >
        std::min(soft + closed, height + open - s.options.finger_clearance))
      return true;
  }
  return false;
}

/// Makes contacts of the grasp of what the pads touch. Two pads that face each other hold by their halves.
/// @return of A, B and C, or of A and twice of B
std::array<PadTouch, 3> touch_with_pads(const Sampler& s, const GripperView& view,
                                        std::span<const FingerStrip> strips, double tip, Grasp& grasp) {
  const auto touch_of = [&](const FingerStrip& strip, double low, double high) {
    return touched(s.gripper, s.surface, s.options.pad_softness, view, strip, tip, low, high);
  };
  std::array<PadTouch, 3> touch;
  grasp.contacts = 0;
  for (std::size_t i = 0; i < strips.size(); ++i) touch[i] = touch_of(strips[i], -1e300, 1e300);
  if (strips.size() == 3) {
    for (const PadTouch& pad : touch) add_contact(grasp, pad);
    return touch;
  }
  touch[2] = touch[1];
  for (const FingerStrip& strip : strips) {
    for (const PadTouch& half : {touch_of(strip, -1e300, strip.y), touch_of(strip, strip.y, 1e300)})
      if (half.height != kNoStone) add_contact(grasp, half);
    if (strip.side > 0) grasp.on_a = grasp.contacts;
  }
  return touch;
}

/// One orientation, sideways shift and depth.
void try_grasp(Sampler& s, const GripperView& view, std::span<const FingerStrip> strips, double y,
               double tip) {
  ++s.set.tried;
  std::array<double, 3> height{};
  for (std::size_t i = 0; i < 3; ++i)
    height[i] = pad_height(s.gripper, strips[std::min(i, strips.size() - 1)], tip);
  if (std::min({height[0], height[1], height[2]}) == kNoStone ||
      std::abs(height[1] - height[2]) > s.options.unequal) {
    ++s.set.no_contact;
    return;
  }
  const double left = height[0], right = -std::max(height[1], height[2]);
  Grasp grasp;
  grasp.spacing = s.gripper.finger_spacing;
  grasp.opening = left - right;
  grasp.pre_opening = std::min(s.gripper.max_opening, grasp.opening + 2 * s.options.finger_clearance);
  if (s.set.narrowest == 0.0 || grasp.opening < s.set.narrowest) s.set.narrowest = grasp.opening;
  const double widest = s.gripper.max_opening - s.options.finger_clearance;
  if (grasp.opening < s.gripper.min_object || grasp.opening > widest) {
    ++s.set.too_wide;
    return;
  }
  const double z = tip - tip_advance(s.gripper, grasp.opening);
  bool in_stone = view.back < z + s.palm_front + s.options.palm_clearance;
  for (std::size_t i = 0; i < strips.size(); ++i)
    in_stone |= upper_finger_touches(s, strips[i], {view.back, tip, z}, grasp, height[i]);
  if (in_stone) {
    ++s.set.gripper_in_stone;
    return;
  }
  grasp.T_O_T.linear() = view.R_O_T;
  grasp.T_O_T.translation() = s.stone.mass.p_O_M + view.R_O_T * Eigen::Vector3d(0.5 * (left + right), y, z);
  const std::array<PadTouch, 3> touch = touch_with_pads(s, view, strips, tip, grasp);
  judge(s, grasp, touch);
}

double tip_depth(const GraspOptions& o, int step) {
  const double share = o.depths > 1 ? static_cast<double>(step) / (o.depths - 1) : 0.5;
  return o.shallowest + share * (o.deepest - o.shallowest);
}

/// By how much the gripper is turned about its approach from where B and C meet the stone together, or where
/// two pads lie flat on it; empty where they meet nothing.
std::optional<double> misturn(const Sampler& s, const GripperView& view, double tip) {
  if (s.gripper.against == 1) return turn_of_pads(s.gripper, view, tip);
  const auto [b, c] = heights_of_b_and_c(s.gripper, view, tip);
  if (b == kNoStone || c == kNoStone) return std::nullopt;
  return std::atan2(b - c, s.gripper.finger_spacing);
}

/// The view with the gripper turned about its approach until B and C meet the stone together, or two pads lie
/// flat on it, by at most half a yaw step.
GripperView equalised(const Sampler& s, const Eigen::Matrix3d& R_O_T) {
  GripperView view = seen_from(s, R_O_T);
  const double max = std::numbers::pi / s.options.yaws;
  double turned = 0.0;
  const double tip = tip_depth(s.options, s.options.depths / 2);
  for (int round = 0; round < kEqualiseRounds; ++round) {
    const std::optional<double> off = misturn(s, view, tip);
    if (!off) break;
    const double angle = std::clamp(turned + *off, -max, max) - turned;
    if (std::abs(angle) < 0.005) break;
    turned += angle;
    view = seen_from(s, view.R_O_T * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  }
  return view;
}

/// All depths of one orientation, and sideways shifts where the middle gives nothing.
void try_orientation(Sampler& s, const GripperView& view) {
  const std::size_t before = s.set.grasps.size();
  for (const double y : {0.0, -s.options.sideways, s.options.sideways}) {
    if (y != 0.0 && s.set.grasps.size() > before) break;
    const FingerStrips strips = cut_strips(s.gripper, view, y);
    for (int d = 0; d < s.options.depths; ++d) try_grasp(s, view, strips.all(), y, tip_depth(s.options, d));
  }
}

/// All yaws about one direction of approach.
void try_direction(Sampler s, const Eigen::Vector3d& z) {
  const Eigen::Vector3d across = z.unitOrthogonal();
  for (int i = 0; i < s.options.yaws; ++i) {
    Eigen::Matrix3d R_O_T;
    R_O_T.col(0) = Eigen::AngleAxisd(2 * std::numbers::pi * i / s.options.yaws, z) * across;
    R_O_T.col(2) = z;
    R_O_T.col(1) = z.cross(R_O_T.col(0));
    try_orientation(s, equalised(s, R_O_T));
  }
}

void append(const GraspSet& part, GraspSet& all) {
  all.grasps.insert(all.grasps.end(), part.grasps.begin(), part.grasps.end());
  for (const auto count : {&GraspSet::tried, &GraspSet::too_wide, &GraspSet::no_contact,
                           &GraspSet::gripper_in_stone, &GraspSet::slips, &GraspSet::too_heavy})
    all.*count += part.*count;
  if (part.narrowest > 0.0 && (all.narrowest == 0.0 || part.narrowest < all.narrowest))
    all.narrowest = part.narrowest;
}

void sort_by_score(GraspSet& set) {
  std::stable_sort(set.grasps.begin(), set.grasps.end(),
                   [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
}

/// All directions and yaws at one spacing of the fingers.
void sample_grasps(Sampler s) {
  s.palm_front = palm_front(s.gripper);
  const std::vector<Eigen::Vector3d> directions = approaches(s.options);
  std::vector<GraspSet> parts(directions.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t k) {
    throw_if_interrupted();
    try_direction({s.stone, s.gripper, s.options, s.surface, parts[k], s.score_factor, s.palm_front},
                  directions[k]);
  });
  for (const GraspSet& part : parts) append(part, s.set);
}

}  // namespace

FieldList fields(GraspOptions& o) {
  return {field("directions", o.directions, {8, 50000}, "", "measured: bench grasp"),
          field("yaws", o.yaws, {2, 360}, "", "measured: bench grasp"),
          field("spacing", o.spacing, {0.0005, 0.05}, "m", "design choice"),
          field("shallowest", o.shallowest, {-0.05, 0.1}, "m", "design choice"),
          field("deepest", o.deepest, {-0.05, 0.1}, "m", "design choice"),
          field("depths", o.depths, {1, 50}, "", "design choice"),
          field("sideways", o.sideways, {0, 0.05}, "m", "design choice"),
          field("pad_softness", o.pad_softness, {1e-5, 0.01}, "m", "design choice"),
          field("unequal", o.unequal, {1e-4, 0.05}, "m", "design choice"),
          field("finger_clearance", o.finger_clearance, {0, 0.05}, "m", "design choice"),
          field("palm_clearance", o.palm_clearance, {0, 0.05}, "m", "design choice"),
          field("friction_share", o.friction_share, {0.05, 1}, "", "design choice"),
          field("force_factor", o.force_factor, {1, 10}, "", "design choice: holds with a factor 2"),
          field("cone", o.cone, {0, 3.2}, "rad", "design choice"),
          field("narrow_score", o.narrow_score, {0, 1}, "", "design choice")};
}

double holding_force(const Grasp& grasp, double weight, const Eigen::Vector3d& n_T_down) {
  double force = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    force += std::abs(n_T_down[axis]) *
             grasp.force_per_weight[static_cast<std::size_t>(2 * axis + (n_T_down[axis] < 0 ? 1 : 0))];
  return weight * force;
}

GraspSet grasp_candidates(const Stone& stone, const GripperModel& gripper, const GraspOptions& options) {
  require(!stone.scan.faces.empty() && stone.mass.mass > 0, "stone ", stone.name,
          " cannot be grasped without a scan and a mass; it has ", stone.scan.faces.size(), " faces and ",
          stone.mass.mass, " kg");
  const double spacing = gripper.against == 1
                             ? std::min(options.spacing, gripper.finger_width / kSamplesAcross)
                             : options.spacing;
  const auto surface = sample_surface(stone.scan, spacing);
  require(options.n_O_towards.isZero() || std::abs(options.n_O_towards.norm() - 1.0) < 1e-6, "approaches of ",
          stone.name, " are wanted towards a unit vector, not ", options.n_O_towards.transpose());
  GraspSet set;
  sample_grasps({stone, gripper, options, surface, set});
  if (gripper.narrow_spacing > 0) {
    Sampler narrow{stone, with_spacing(gripper, gripper.narrow_spacing), options, surface, set};
    narrow.score_factor = options.narrow_score;
    narrow.options.unequal *= gripper.narrow_spacing / gripper.finger_spacing;  // the same turn of the stone
    sample_grasps(std::move(narrow));
  }
  sort_by_score(set);
  return set;
}

GraspSet joined(const GraspSet& a, const GraspSet& b) {
  GraspSet both = a;
  append(b, both);
  sort_by_score(both);
  return both;
}

}  // namespace stonestack::motion
