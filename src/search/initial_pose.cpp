#include "search/initial_pose.hpp"

#include <algorithm>

namespace stonestack::search {
namespace {

constexpr double kTouchGap = 0.001;  ///< [m]

}  // namespace

Target target_of(const SearchContext& context) {
  Target target;
  target.p_W_centroid << context.problem->site, 0.0;
  target.p_W_previous_com = target.p_W_centroid;
  const Stack& stack = context.stack;
  if (stack.stones.empty()) return target;
  const PlacedStone& top = stack.stones.back();
  target.p_W_previous_com = top.T_W_O * at(context.geometry, top.stone).p_O_M;
  const int last = static_cast<int>(stack.stones.size()) - 1;
  std::vector<Contact> under_top;
  for (const Contact& contact : geometric_contacts(context.shapes(), stack, kTouchGap))
    if (contact.above == last) under_top.push_back(contact);
  const SupportPolygon polygon = support_polygon(under_top, target.p_W_previous_com, kTouchGap);
  if (polygon.corners_W.size() < 3) {
    target.p_W_centroid = target.p_W_previous_com;
    return target;
  }
  target.p_W_centroid = polygon.p_W_centroid;
  target.n_W = polygon.n_W.normalized();
  return target;
}

Eigen::Matrix3d initial_orientation(const Eigen::Matrix3d& R_W_O_detected, double theta_init,
                                    Random& random) {
  const Eigen::Vector3d axis = random.unit_vector();
  return Eigen::AngleAxisd(random.uniform(-theta_init, theta_init), axis) * R_W_O_detected;
}

Pose placed_along_normal(const SearchContext& context, const Target& target, StoneIndex stone,
                         const Eigen::Matrix3d& R_W_O, const Eigen::Vector3d& aside) {
  const StoneGeometry& geometry = at(context.geometry, stone);
  const Eigen::Vector3d& n = target.n_W;
  double top = 0.0;  // of the stack along n_j, from C_j
  for (const BodyPose& body : bodies_of(context, context.stack))
    for (const Eigen::Vector3d& v : body.stone->vertices_M)
      top = std::max(top, (body.R_W_O * v + body.p_W_M - target.p_W_centroid).dot(n));
  double bottom = 0.0;  // of the stone along n_j, from its centre of mass
  for (const Eigen::Vector3d& v : geometry.vertices_M) bottom = std::min(bottom, (R_W_O * v).dot(n));
  const double along = top - bottom + context.options->initial_gap - aside.dot(n);
  return stone_pose({&geometry, R_W_O, target.p_W_centroid + aside + along * n});
}

}  // namespace stonestack::search
