#include "collision_reference.hpp"

#include <CGAL/Cartesian.h>
#include <CGAL/MP_Float.h>
#include <CGAL/Polytope_distance_d.h>
#include <CGAL/Polytope_distance_d_traits_3.h>

#include <cmath>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::bench {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Kernel = CGAL::Cartesian<double>;
using Traits = CGAL::Polytope_distance_d_traits_3<Kernel, CGAL::MP_Float, double>;

Points moved(const Points& points, const Pose& T) {
  Points result;
  for (const Eigen::Vector3d& p : points) result.push_back(T * p);
  return result;
}

/// Lower bound of the distance: spheres around the points.
double sphere_gap(const Points& a, const Points& b) {
  const auto sphere = [](const Points& points) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const auto& p : points) centre += p / static_cast<double>(points.size());
    double radius = 0.0;
    for (const auto& p : points) radius = std::max(radius, (p - centre).norm());
    return std::pair{centre, radius};
  };
  const auto [ca, ra] = sphere(a);
  const auto [cb, rb] = sphere(b);
  return (ca - cb).norm() - ra - rb;
}

/// Another lower bound: along each axis.
double box_gap(const Points& a, const Points& b) {
  Eigen::AlignedBox3d box_a, box_b;
  for (const auto& p : a) box_a.extend(p);
  for (const auto& p : b) box_b.extend(p);
  return std::sqrt(box_a.squaredExteriorDistance(box_b));
}

/// True for links that are bolted together or meet in every pose (as the checker's documentation says).
bool never_checked(int low, int high, bool arm) {
  if (high - low < 2) return true;
  return arm && ((low == 0 && high == 2) || (low == 3 && high == 5) || (low == 4 && high == 6));
}

}  // namespace

double hull_gap(const Points& a, const Points& b) {
  std::vector<Kernel::Point_3> p, q;
  for (const auto& v : a) p.emplace_back(v.x(), v.y(), v.z());
  for (const auto& v : b) q.emplace_back(v.x(), v.y(), v.z());
  const CGAL::Polytope_distance_d<Traits> distance(p.begin(), p.end(), q.begin(), q.end());
  return std::sqrt(CGAL::to_double(distance.squared_distance_numerator()) /
                   CGAL::to_double(distance.squared_distance_denominator()));
}

CollisionReference::CollisionReference(const PlanningScene& scene, const CollisionRules& rules)
    : scene_(scene), rules_(rules) {
  for (const LinkCapsule& c : scene.robot.capsules) movers_.push_back({c.link, false, {c.a, c.b}, c.radius});
  const Pose T_6_T = scene.robot.T_6_F * scene.T_F_T;
  for (const GripperBox& box : scene.gripper.boxes) {
    const Pose T_T_box(
        Eigen::Translation3d(box.p_T_centre + Eigen::Vector3d(0.5 * rules.opening * box.finger_side, 0, 0)));
    movers_.push_back({6, true, moved(make_box(box.size).vertices, T_6_T * T_T_box), 0.0});
  }
  for (const SceneObject& object : scene.objects)
    for (const Mesh& piece : object.pieces)
      obstacles_R_.push_back(moved(piece.vertices, scene.T_W_R.inverse() * object.T_W_object));
}

double CollisionReference::min_gap(const Joints& q, double near) const {
  const auto links = link_poses(scene_.robot, q);
  std::vector<Points> placed;
  for (const Shape& m : movers_) placed.push_back(moved(m.points, links[static_cast<std::size_t>(m.link)]));
  double min = 1.0;
  const auto add = [&](const Points& a, const Points& b, double radii, double padding) {
    const double away = radii + padding + near;
    if (sphere_gap(a, b) > away || box_gap(a, b) > away) return;
    min = std::min(min, hull_gap(a, b) - radii - padding);
  };
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    if (!movers_[i].gripper && movers_[i].link < 2) continue;
    for (const auto& p : placed[i])
      min = std::min(min, (scene_.T_W_R * p).z() - scene_.table_z - movers_[i].radius - rules_.padding);
  }
  for (std::size_t i = 0; i < movers_.size() && min > -near; ++i) {
    if (movers_[i].link > 0)
      for (const auto& obstacle : obstacles_R_)
        if (min > -near) add(placed[i], obstacle, movers_[i].radius, rules_.padding);
    for (std::size_t j = 0; j < movers_.size() && min > -near; ++j)
      if (movers_[i].link < movers_[j].link &&
          !never_checked(movers_[i].link, movers_[j].link, !movers_[i].gripper && !movers_[j].gripper))
        add(placed[i], placed[j], movers_[i].radius + movers_[j].radius, rules_.self_padding);
  }
  return min;
}

}  // namespace stonestack::bench
