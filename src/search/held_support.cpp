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

/// Mass, and mass times centre of mass, of bodies.
struct Load {
  double mass = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();

  void add(const BodyPose& body) {
    mass += body.stone->mass;
    moment += body.stone->mass * body.p_W_M;
  }
  [[nodiscard]] Eigen::Vector2d centre() const { return (moment / mass).head<2>(); }
};

Load load_of(std::span<const BodyPose> bodies) {
  Load load;
  for (const BodyPose& body : bodies) load.add(body);
  return load;
}

double lowest_point(const BodyPose& body) {
  double z = 1e300;
  for (const Eigen::Vector3d& p_M : body.stone->vertices_M)
    z = std::min(z, body.R_W_O.row(2).dot(p_M) + body.p_W_M.z());
  return z;
}

}  // namespace

std::vector<Rest> held_rests(std::span<const BodyPose> bodies, int held) {
  const auto count = static_cast<std::size_t>(held);
  require(count <= bodies.size(), "of ", bodies.size(), " bodies ", held, " cannot be held");
  std::vector<Rest> rests(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d p_W = load_of(bodies.subspan(k, count - k)).centre();
    std::vector<Eigen::Vector2d> corners;
    for (int c = 0; c < kCorners; ++c) {
      const double angle = 2.0 * M_PI * c / kCorners;
      corners.push_back(p_W + kMargin * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    rests[k] = {convex_hull(std::move(corners)), lowest_point(bodies[k])};
  }
  return rests;
}

bool tips_held(std::span<const BodyPose> bodies, std::span<const PlacedStone> stones, int held,
               std::uint64_t seed, int world) {
  const auto count = static_cast<std::size_t>(held);
  require(count <= bodies.size() && stones.size() == bodies.size(), "of ", bodies.size(), " bodies ", held,
          " cannot be held");
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d before = load_of(bodies.subspan(k, count - k)).centre();
    const Eigen::Vector2d now = load_of(bodies.subspan(k)).centre();
    Random random = Random::stream(seed, concat("support of held stone ", stones[k].stone, " ", world));
    if ((now - before).norm() > kMargin * std::exp(random.normal(0.0, kMarginSpread))) return true;
  }
  return false;
}

}  // namespace stonestack::search
