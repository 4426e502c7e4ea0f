#include "search/held_support.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {
namespace {

/// Margin by which the centre of mass of a stone at rest lies within its support, m: median, and standard
/// deviation of its logarithm. Measured on the table, contacts within 0.5 mm: scanned rocks 3.3, 5.9 and
/// 11 mm in the quartiles (177 resting poses of 20), limestones 4.6, 6.3 and 9.2 mm.
constexpr double kMargin = 0.006;
constexpr double kMarginSpread = 0.7;
constexpr int kCorners = 8;

/// Centre of mass of bodies, seen from above.
Eigen::Vector2d centre_of(std::span<const BodyPose> bodies) {
  const Interface under = interface_under(bodies);
  return (under.moment_above / under.mass_above).head<2>();
}

double lowest_point(const BodyPose& body) {
  double z = 1e300;
  for (const Eigen::Vector3d& p_M : body.stone->vertices_M)
    z = std::min(z, body.R_W_O.row(2).dot(p_M) + body.p_W_M.z());
  return z;
}

}  // namespace

std::vector<Interface> held_interfaces(std::span<const BodyPose> bodies, int held) {
  const auto count = static_cast<std::size_t>(held);
  require(count <= bodies.size(), "of ", bodies.size(), " bodies ", held, " cannot be held");
  std::vector<Interface> list;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d p_W = centre_of(bodies.subspan(k, count - k));
    std::vector<Eigen::Vector2d> corners;
    for (int c = 0; c < kCorners; ++c) {
      const double angle = 2.0 * M_PI * c / kCorners;
      corners.push_back(p_W + kMargin * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    Interface& support = list.emplace_back(interface_under(bodies.subspan(k)));
    support.rest = {convex_hull(std::move(corners)), lowest_point(bodies[k])};
  }
  return list;
}

bool tips_held(std::span<const BodyPose> bodies, std::span<const PlacedStone> stones, int held,
               std::uint64_t seed, int world) {
  const auto count = static_cast<std::size_t>(held);
  require(count <= bodies.size() && stones.size() == bodies.size(), "of ", bodies.size(), " bodies ", held,
          " cannot be held");
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d before = centre_of(bodies.subspan(k, count - k));
    const Eigen::Vector2d now = centre_of(bodies.subspan(k));
    Random random = Random::stream(seed, concat("support of held stone ", stones[k].stone, " ", world));
    if ((now - before).norm() > kMargin * std::exp(random.normal(0.0, kMarginSpread))) return true;
  }
  return false;
}

}  // namespace stonestack::search
