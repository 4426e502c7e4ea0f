#include "stonestack/physics/equilibrium.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "physics/linear_programme.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kMaxFriction = 2.0;    // `min_friction` is looked for up to here
constexpr double kMaxMargin = 5.0;      // g
constexpr double kFrictionStep = 1e-3;  // of `min_friction`

void check_input(std::span<const StaticBody> bodies, std::span<const Contact> contacts,
                 const EquilibriumOptions& o) {
  require(o.friction >= 0.0 && std::isfinite(o.friction), "friction must not be negative, got ", o.friction);
  require(o.cone_edges >= 3 && o.directions >= 1, "the cone needs 3 edges and the margin one direction, got ",
          o.cone_edges, " and ", o.directions);
  for (const StaticBody& body : bodies)
    require(body.mass > 0.0 && std::isfinite(body.mass), "every body needs a positive mass, got ", body.mass,
            " kg");
  for (const StaticBody& body : bodies)
    require(body.p_W_com.allFinite(), "every body needs a finite centre of mass, got ", body.p_W_com.x(),
            ", ", body.p_W_com.y(), ", ", body.p_W_com.z());
  for (const Contact& c : contacts)
    require(c.p_W.allFinite() && c.n_W.allFinite(), "every contact needs a finite point and normal");
  for (const Contact& c : contacts)
    for (const int body : {c.below, c.above})
      require(body >= kTable && body < static_cast<int>(bodies.size()), "a contact names body ", body,
              "; there are ", bodies.size());
}

/// Indices of the contacts that count: of those alike, the first; none of a body with itself.
std::vector<std::size_t> distinct(std::span<const Contact> contacts) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    if (c.below == c.above) continue;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](std::size_t k) {
      const Contact& o = contacts[k];
      return o.below == c.below && o.above == c.above && (o.p_W - c.p_W).squaredNorm() < 1e-6 &&
             o.n_W.dot(c.n_W) > 0.9986;
    });
    if (!known) kept.push_back(i);
  }
  return kept;
}

/// The linear programme: columns are the generators of the friction cones, then the horizontal acceleration;
/// rows are the forces and torques on each body, in shares of the total weight.
class Balance {
 public:
  Balance(std::span<const StaticBody> bodies, std::span<const Contact> contacts,
          std::vector<std::size_t> used, const EquilibriumOptions& options)
      : bodies_(bodies), contacts_(contacts), used_(std::move(used)), options_(options) {
    for (const StaticBody& body : bodies) total_ += body.mass;
  }

  /// Balanced at rest with this friction? Keeps the programme for `push`.
  bool feasible(double friction) {
    build(friction);
    if (!programme_->solve(options_.tolerance)) return false;
    at_rest_ = programme_->basis();
    return true;
  }

  struct Push {
    double acceleration = 0.0;  ///< in g
    int weakest = -1;           ///< into the contacts
  };
  /// Largest acceleration along a unit direction, or `most` if it is not smaller, from the programme solved
  /// at rest.
  Push push(const Eigen::Vector2d& direction, double friction, double most) {
    const int column = generators();
    std::vector<LinearProgramme::Entry> entries;
    for (int b = 0; b < static_cast<int>(bodies_.size()); ++b)
      for (int i = 0; i < 2; ++i) entries.push_back({6 * b + i, share(b) * direction[i]});
    programme_->set_basis(at_rest_);
    programme_->set_column(column, entries);
    programme_->set_upper(column, most);
    programme_->set_gain(column, 1.0);
    const bool solved = programme_->solve(options_.tolerance);
    return {solved ? std::max(programme_->value(column), 0.0) : 0.0, weakest(friction)};
  }

 private:
  [[nodiscard]] int generators() const { return static_cast<int>(used_.size()) * options_.cone_edges; }
  [[nodiscard]] double share(int body) const { return bodies_[static_cast<std::size_t>(body)].mass / total_; }

  /// Tangential part of generator k.
  [[nodiscard]] Vector tangent(const Contact& c, int k) const {
    const Vector u = c.n_W.unitOrthogonal();
    const double angle = 2 * M_PI * k / options_.cone_edges;
    return std::cos(angle) * u + std::sin(angle) * c.n_W.cross(u);
  }

  /// Force and scaled torque of `f` at the contact on one of its bodies.
  [[nodiscard]] Eigen::Matrix<double, 6, 1> wrench(const Contact& c, int body, const Vector& f) const {
    Eigen::Matrix<double, 6, 1> w;
    const Vector arm = c.p_W - bodies_[static_cast<std::size_t>(body)].p_W_com;
    w << f, arm.cross(f) / options_.torque_arm;
    return body == c.above ? w : Eigen::Matrix<double, 6, 1>(-w);
  }

  void build(double friction) {
    std::vector<double> weight(6 * bodies_.size(), 0.0);
    for (std::size_t b = 0; b < bodies_.size(); ++b) weight[6 * b + 2] = share(static_cast<int>(b));
    programme_.emplace(weight);
    std::vector<LinearProgramme::Entry> entries;
    for (const std::size_t i : used_)
      for (int k = 0; k < options_.cone_edges; ++k) {
        const Contact& c = contacts_[i];
        const Vector f = c.n_W + friction * tangent(c, k);
        entries.clear();
        for (const int body : {c.below, c.above}) {
          if (body == kTable) continue;
          const auto w = wrench(c, body, f);
          for (int r = 0; r < 6; ++r) entries.push_back({6 * body + r, w[r]});
        }
        programme_->add_column(entries);
      }
    programme_->set_upper(programme_->add_column({}), 0.0);  // the acceleration, for `push` to fill in
  }

  /// Of the programme just solved.
  [[nodiscard]] int weakest(double friction) const {
    int slides = -1, tips = -1;
    double gain = 1e-6, load = 0.0;
    for (std::size_t j = 0; j < used_.size(); ++j) {
      const Contact& c = contacts_[used_[j]];
      double carried = 0.0, gained = 0.0;
      for (int k = 0; k < options_.cone_edges; ++k) {
        const double force = programme_->value(static_cast<int>(j) * options_.cone_edges + k);
        carried += force;
        for (const int body : {c.below, c.above}) {
          if (body == kTable) continue;
          const auto w = wrench(c, body, friction * tangent(c, k));
          for (int r = 0; r < 6; ++r) gained += force * programme_->multiplier(6 * body + r) * w[r];
        }
      }
      if (std::abs(gained) > gain) gain = std::abs(gained), slides = static_cast<int>(used_[j]);
      if (carried > load) load = carried, tips = static_cast<int>(used_[j]);
    }
    return slides >= 0 ? slides : tips;
  }

  std::span<const StaticBody> bodies_;
  std::span<const Contact> contacts_;
  std::vector<std::size_t> used_;
  EquilibriumOptions options_;
  double total_ = 0.0;
  std::optional<LinearProgramme> programme_;
  LinearProgramme::Basis at_rest_;
};

/// Smallest friction that balances, by bisection; `stands` is the answer at `friction`.
double min_friction(Balance& balance, double friction, bool stands) {
  double low = stands ? 0.0 : friction;
  double high = stands ? friction : kMaxFriction;
  if (!stands && (friction >= high || !balance.feasible(high)))
    return std::numeric_limits<double>::infinity();
  if (stands && balance.feasible(0.0)) return 0.0;
  while (high - low > kFrictionStep * std::max(high, 0.05)) {
    const double middle = 0.5 * (low + high);
    (balance.feasible(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

Equilibrium solve_equilibrium(std::span<const StaticBody> bodies, std::span<const Contact> contacts,
                              const EquilibriumOptions& options) {
  check_input(bodies, contacts, options);
  Equilibrium result;
  if (bodies.empty()) {
    result.stands = true;
    result.margin = kMaxMargin;
    return result;
  }
  Balance balance(bodies, contacts, distinct(contacts), options);
  result.stands = balance.feasible(options.friction);
  if (result.stands) {
    result.margin = kMaxMargin;
    for (int k = 0; k < options.directions; ++k) {
      const double angle = 2 * M_PI * k / options.directions;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const auto push = balance.push(direction, options.friction, result.margin);
      if (push.acceleration >= result.margin) continue;
      result.margin = push.acceleration;
      result.direction = direction;
      result.weakest_contact = push.weakest;
    }
  }
  if (options.min_friction) result.min_friction = min_friction(balance, options.friction, result.stands);
  return result;
}

}  // namespace stonestack::physics
