#include "physics/coupled_analysis.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

using Wrench = Eigen::Matrix<double, 6, 1>;
using Jacobian = Eigen::Matrix<double, 3, 6>;

constexpr double kBalanced = 1e-4;         // of a body's weight: an unbalanced force that counts as none
constexpr double kSolved = 1e-8;           // of the total weight: accuracy of a Newton step's equations
constexpr int kNewtonSteps = 20;           // of one creep step
constexpr int kStalls = 3;                 // steps without progress that end Newton's method
constexpr int kCreepSteps = 60;            // at most
constexpr double kFirstViscosity = 1.0;    // times the stiffness of a body's contacts
constexpr double kViscosityStep = 0.05;    // factor after a creep step that was solved
constexpr double kLastViscosity = 1e-9;    // a body that still moves falls
constexpr double kCreepsOn = 0.9;          // share of the unbalanced force that a falling body keeps
constexpr double kCoupledMaxMargin = 5.0;  // g
constexpr double kCoupledMaxFriction = 2.0;
constexpr double kMarginStep = 5e-3;           // relative accuracy of the margin
constexpr double kCoupledFrictionStep = 2e-3;  // of the smallest friction

void check_assembly_input(std::span<const StaticBody> bodies, std::span<const BlockContact> contacts) {
  for (const StaticBody& body : bodies)
    require(body.mass > 0.0 && std::isfinite(body.mass) && body.p_W_com.allFinite(),
            "every body needs a positive mass and a finite centre of mass, got ", body.mass, " kg");
  for (const BlockContact& c : contacts) {
    require(c.contact.p_W.allFinite() && c.contact.n_W.allFinite(),
            "every contact needs a finite point and normal");
    require(c.stiffness > 0.0 && std::isfinite(c.stiffness), "every contact needs a positive stiffness, got ",
            c.stiffness);
    for (const int body : {c.contact.below, c.contact.above})
      require(body >= kTable && body < static_cast<int>(bodies.size()), "a contact names body ", body,
              "; there are ", bodies.size());
  }
}

}  // namespace

struct CoupledSolver::Parts {
  /// A contact in its own axes: normal, two tangents.
  struct Joint {
    int below, above;
    double stiffness;
    Eigen::Matrix3d axes;  ///< rows: normal, tangents (W)
    Jacobian of_below, of_above;
  };
  std::vector<Joint> joints;
  std::vector<double> shares;     ///< mass over total mass
  std::vector<double> viscosity;  ///< of each body: mean stiffness of its contacts
  int size = 0;
  Eigen::SparseMatrix<double> matrix;
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> lu;
  std::map<std::pair<int, int>, std::array<double*, 6>> blocks;  ///< (row body, column body): its six columns
  std::vector<std::array<double*, 6>> diagonal;
  struct Places {
    std::array<double*, 6> aa, ab, ba, bb;
  };
  std::vector<Places> places;

  Parts(std::span<const StaticBody> bodies, std::span<const BlockContact> contacts) {
    const auto n = bodies.size();
    size = 6 * static_cast<int>(n);
    double total = 0.0, mean = 0.0;
    for (const StaticBody& body : bodies) total += body.mass;
    for (const StaticBody& body : bodies) shares.push_back(body.mass / total);
    double reach = 0.0;
    for (const BlockContact& c : contacts)
      for (const int b : {c.contact.below, c.contact.above})
        if (b != kTable)
          reach = std::max(reach, (c.contact.p_W - bodies[static_cast<std::size_t>(b)].p_W_com).norm());
    const double length = reach > 0.0 ? 0.5 * reach : 1.0;
    for (const BlockContact& c : contacts) mean += c.stiffness / static_cast<double>(contacts.size());
    viscosity.assign(n, 0.0);
    for (const BlockContact& c : contacts) {
      if (c.contact.below == c.contact.above) {
        joints.push_back(
            {kTable, kTable, 0.0, Eigen::Matrix3d::Identity(), Jacobian::Zero(), Jacobian::Zero()});
        continue;
      }
      Joint joint{c.contact.below,  c.contact.above, c.stiffness / mean, {},
                  Jacobian::Zero(), Jacobian::Zero()};
      const Eigen::Vector3d normal = c.contact.n_W.normalized(), u = normal.unitOrthogonal();
      joint.axes.row(0) = normal;
      joint.axes.row(1) = u;
      joint.axes.row(2) = normal.cross(u);
      const auto jacobian = [&](int b) {
        Jacobian out;
        const Eigen::Vector3d arm = (c.contact.p_W - bodies[static_cast<std::size_t>(b)].p_W_com) / length;
        for (int i = 0; i < 3; ++i) {
          out.row(i).head<3>() = joint.axes.row(i);
          out.row(i).tail<3>() = arm.cross(Eigen::Vector3d(joint.axes.row(i).transpose())).transpose();
        }
        return out;
      };
      if (joint.above != kTable) joint.of_above = jacobian(joint.above);
      if (joint.below != kTable) joint.of_below = -jacobian(joint.below);
      for (const int b : {joint.below, joint.above})
        if (b != kTable) viscosity[static_cast<std::size_t>(b)] += joint.stiffness;
      joints.push_back(joint);
    }
    for (double& v : viscosity) v = std::max(v, 1e-3);
    make_pattern(static_cast<int>(n));
  }

  void make_pattern(int n) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](int row, int column) {
      if (!blocks.try_emplace({row, column}).second) return;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) entries.emplace_back(6 * row + i, 6 * column + j, 0.0);
    };
    for (int b = 0; b < n; ++b) add(b, b);
    for (const Joint& joint : joints)
      if (joint.below != kTable && joint.above != kTable) {
        add(joint.below, joint.above);
        add(joint.above, joint.below);
      }
    matrix.resize(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    matrix.makeCompressed();
    for (auto& [key, columns] : blocks)
      for (int j = 0; j < 6; ++j)
        columns[static_cast<std::size_t>(j)] = &matrix.coeffRef(6 * key.first, 6 * key.second + j);
    for (int b = 0; b < n; ++b) diagonal.push_back(blocks.at({b, b}));
    for (const Joint& joint : joints) {
      Places p{};
      if (joint.above != kTable) p.aa = blocks.at({joint.above, joint.above});
      if (joint.below != kTable) p.bb = blocks.at({joint.below, joint.below});
      if (joint.above != kTable && joint.below != kTable) {
        p.ab = blocks.at({joint.above, joint.below});
        p.ba = blocks.at({joint.below, joint.above});
      }
      places.push_back(p);
    }
    if (size > 0) lu.analyzePattern(matrix);
  }

  /// Force of a joint in its axes, on `above`, for a relative motion `d` of above against below; the
  /// derivative goes to `slope`.
  static Eigen::Vector3d force(const Eigen::Vector3d& d, double k, double friction, Eigen::Matrix3d* slope) {
    slope->setZero();
    if (d[0] >= 0.0) return Eigen::Vector3d::Zero();
    const double normal = -k * d[0];
    (*slope)(0, 0) = -k;
    const Eigen::Vector2d trial = -k * d.tail<2>();
    const double length = trial.norm(), limit = friction * normal;
    if (length <= limit) {
      (*slope)(1, 1) = (*slope)(2, 2) = -k;
      return {normal, trial.x(), trial.y()};
    }
    const Eigen::Vector2d along = trial / length;
    slope->block<2, 1>(1, 0) = -k * friction * along;
    slope->block<2, 2>(1, 1) =
        -k * limit / length * (Eigen::Matrix2d::Identity() - along * along.transpose());
    return {normal, limit * along.x(), limit * along.y()};
  }

  static void add_block(const std::array<double*, 6>& place, const Eigen::Matrix<double, 6, 6>& value) {
    for (int j = 0; j < 6; ++j) Eigen::Map<Wrench>(place[static_cast<std::size_t>(j)]) += value.col(j);
  }

  /// Forces on the bodies (contacts only); with `derivative` also the matrix of their derivative.
  Eigen::VectorXd forces(const Eigen::VectorXd& motion, double friction, bool derivative,
                         std::vector<Eigen::Vector3d>* each = nullptr) {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(size);
    if (derivative) Eigen::Map<Eigen::VectorXd>(matrix.valuePtr(), matrix.nonZeros()).setZero();
    Eigen::Matrix3d slope;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const Joint& joint = joints[i];
      Eigen::Vector3d d = Eigen::Vector3d::Zero();
      if (joint.above != kTable) d += joint.of_above * motion.segment<6>(6 * joint.above);
      if (joint.below != kTable) d += joint.of_below * motion.segment<6>(6 * joint.below);
      const Eigen::Vector3d f = force(d, joint.stiffness, friction, &slope);
      if (each) each->push_back(joint.axes.transpose() * f);
      if (f[0] == 0.0) continue;
      if (joint.above != kTable) out.segment<6>(6 * joint.above) += joint.of_above.transpose() * f;
      if (joint.below != kTable) out.segment<6>(6 * joint.below) += joint.of_below.transpose() * f;
      if (!derivative) continue;
      const Places& place = places[i];
      if (joint.above != kTable) add_block(place.aa, joint.of_above.transpose() * slope * joint.of_above);
      if (joint.below != kTable) add_block(place.bb, joint.of_below.transpose() * slope * joint.of_below);
      if (joint.above == kTable || joint.below == kTable) continue;
      add_block(place.ab, joint.of_above.transpose() * slope * joint.of_below);
      add_block(place.ba, joint.of_below.transpose() * slope * joint.of_above);
    }
    return out;
  }

  [[nodiscard]] Eigen::VectorXd drag(const Eigen::VectorXd& moved, double weight) const {
    Eigen::VectorXd out = moved;
    for (std::size_t b = 0; b < viscosity.size(); ++b)
      out.segment<6>(6 * static_cast<Eigen::Index>(b)) *= weight * viscosity[b];
    return out;
  }

  /// One implicit step of creep from `start`; false if Newton's method did not end.
  bool creep(const Eigen::VectorXd& start, const Eigen::VectorXd& load, double friction, double weight,
             Eigen::VectorXd& motion) {
    motion = start;
    Eigen::VectorXd residual = forces(motion, friction, true) + load;
    const double scale = kSolved * load.norm();
    int stalls = 0;
    for (int k = 0; k < kNewtonSteps; ++k) {
      const double norm = residual.norm();
      if (norm <= scale) return true;
      for (std::size_t b = 0; b < diagonal.size(); ++b)
        for (std::size_t j = 0; j < 6; ++j) diagonal[b][j][j] -= weight * viscosity[b];
      lu.factorize(matrix);
      if (lu.info() != Eigen::Success) return false;
      const Eigen::VectorXd step = lu.solve(-residual);
      if (!step.allFinite()) return false;
      double share = 1.0;
      for (int h = 0;; ++h, share *= 0.5) {
        const Eigen::VectorXd next = motion + share * step;
        const Eigen::VectorXd r = forces(next, friction, false) + load - drag(next - start, weight);
        const bool better = r.norm() < (1.0 - 0.1 * share) * norm;
        if (!better && h < 5) continue;
        if (!better && ++stalls >= kStalls) return false;
        motion = next;
        break;
      }
      residual = forces(motion, friction, true) + load - drag(motion - start, weight);
    }
    return residual.norm() <= 1e3 * scale;
  }
};

CoupledSolver::CoupledSolver(std::span<const StaticBody> bodies, std::span<const BlockContact> contacts) {
  check_assembly_input(bodies, contacts);
  parts_ = std::make_unique<Parts>(bodies, contacts);
}

CoupledSolver::~CoupledSolver() = default;

CoupledState CoupledSolver::solve(double friction, const Eigen::Vector3d& load_g, const CoupledState* start) {
  Parts& p = *parts_;
  const auto n = p.shares.size();
  Eigen::VectorXd load = Eigen::VectorXd::Zero(p.size);
  for (std::size_t b = 0; b < n; ++b)
    load.segment<3>(6 * static_cast<Eigen::Index>(b)) = p.shares[b] * load_g;
  CoupledState state;
  Eigen::VectorXd motion = start ? start->motion : Eigen::VectorXd(Eigen::VectorXd::Zero(p.size)), next;
  double viscosity = start ? kFirstViscosity * 0.01 : kFirstViscosity, before = 0.0;
  double decay = kViscosityStep;  // gentler once a creep step was not solved
  int falling = 0;
  for (int k = 0; k < kCreepSteps; ++k) {
    if (!p.creep(motion, load, friction, viscosity, next)) {
      viscosity *= 5.0;
      decay = 0.3;
      if (viscosity > 10.0 * kFirstViscosity) break;
      continue;
    }
    motion = next;
    const Eigen::VectorXd rest = p.forces(motion, friction, false) + load;
    state.unbalanced = 0.0;
    for (std::size_t b = 0; b < n; ++b) {
      const double share = rest.segment<6>(6 * static_cast<Eigen::Index>(b)).norm() / p.shares[b];
      if (share > state.unbalanced) state.unbalanced = share, state.moving = static_cast<int>(b);
    }
    state.stands = state.unbalanced < kBalanced;
    if (state.stands) break;
    falling = viscosity < 1e-4 && state.unbalanced > kCreepsOn * before ? falling + 1 : 0;
    if (falling > 1 || viscosity < kLastViscosity) break;
    before = state.unbalanced;
    viscosity *= decay;
  }
  if (state.stands || n == 0) state.moving = -1;
  state.stands = state.stands || n == 0;
  static_cast<void>(p.forces(motion, friction, false, &state.forces_W));
  state.motion = motion;
  return state;
}

namespace {

/// Contact that uses most of its friction among those that carry something; where none slides, the one that
/// carries most.
int weakest_of(const CoupledState& state, std::span<const BlockContact> contacts, double friction) {
  int slides = -1, carries = -1;
  double used = 0.99, load = 0.0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Eigen::Vector3d& n = contacts[i].contact.n_W;
    const double normal = state.forces_W[i].dot(n);
    if (normal > load) load = normal, carries = static_cast<int>(i);
    if (normal < 1e-4) continue;
    const double share = (state.forces_W[i] - normal * n).norm() / std::max(friction * normal, 1e-12);
    if (share > used) used = share, slides = static_cast<int>(i);
  }
  return slides >= 0 ? slides : carries;
}

/// Index k of `count` directions in an order that covers the circle early: the weakest is met soon, and each
/// later one that bears more costs a single solution.
int spread(int k, int count) {
  return std::gcd(7, count) == 1 ? 7 * k % count : k;
}

double min_coupled_friction(CoupledSolver& solver, double friction, const Eigen::Vector3d& down,
                            const CoupledState& rest) {
  double low = rest.stands ? 0.0 : friction, high = rest.stands ? friction : kCoupledMaxFriction;
  CoupledState last = rest;
  const auto holds = [&](double mu) {
    CoupledState state = solver.solve(mu, down, last.stands ? &last : nullptr);
    const bool stands = state.stands;
    if (stands) last = std::move(state);
    return stands;
  };
  if (!rest.stands && (friction >= high || !holds(high))) return std::numeric_limits<double>::infinity();
  if (rest.stands && holds(0.0)) return 0.0;
  while (high - low > kCoupledFrictionStep * std::max(high, 0.05)) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

CoupledAnalysis analyse_coupled(std::span<const StaticBody> bodies, std::span<const BlockContact> contacts,
                                double friction, int directions, const Eigen::Vector3d& down) {
  require(friction >= 0.0 && std::isfinite(friction), "friction must not be negative, got ", friction);
  CoupledSolver solver(bodies, contacts);
  CoupledAnalysis out;
  out.rest = solver.solve(friction, down);
  if (out.rest.stands) out.margin = kCoupledMaxMargin;
  for (int k = 0; out.rest.stands && k < directions; ++k) {
    const double angle = 2 * M_PI * spread(k, directions) / directions;
    const Eigen::Vector3d push(std::cos(angle), std::sin(angle), 0.0);
    CoupledState last = out.rest;
    const auto bears = [&](double a) {
      CoupledState state = solver.solve(friction, down + a * push, &last);
      const bool stands = state.stands;
      if (stands) last = std::move(state);
      return stands;
    };
    double low = 0.0, high = out.margin;
    if (bears(high * (1.0 - kMarginStep))) continue;
    while (high - low > kMarginStep * std::max(high, 0.05)) {
      const double middle = low == 0.0 && high > 0.5 ? 0.25 * high : 0.5 * (low + high);
      (bears(middle) ? low : high) = middle;
    }
    out.margin = low;
    out.direction = push.head<2>();
    out.weakest_contact = weakest_of(last, contacts, friction);
  }
  out.min_friction = min_coupled_friction(solver, friction, down, out.rest);
  return out;
}

}  // namespace stonestack::physics
