#include "motion/grasp/pad_press.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "motion/grasp/finger_reach.hpp"

namespace stonestack::motion {
namespace {

constexpr std::array<double, 3> kSide{1.0, -1.0, -1.0};
constexpr double kMinFacing = 0.2;  ///< cosine: steeper surface lies beside the pad, not on it
constexpr double kReach = 0.008;    ///< distance [m] before a pad: what may come to lie on it
constexpr double kBehind = 10.0;    ///< times the rubber's stiffness: the finger behind it, which only slides
constexpr double kSlipStiffness = 0.02;  ///< share of the shear stiffness that a slipping sample counts with
constexpr int kSqueezeRounds = 12;
constexpr int kIterations = 12;
constexpr double kUnbalanced = 0.03;  ///< share of the load
constexpr double kMaxMove = 0.003,
                 kMaxTurn = 0.06;      ///< limits [rad] and [m]: beyond them the stone counts as lost
constexpr double kPressLength = 0.05;  ///< makes torques comparable with forces [m]
constexpr double kLoadStep = 0.5;      ///< of the weight
constexpr double kDeepest = 0.02;      ///< that a stone is pressed into a pad [m]
constexpr int kHalvings = 24;          ///< of that

/// Adds J^T diag(along, across, across) J to the lower triangle of `K`, where J = (1, -[r]x) is how a point
/// at `r` follows the stone's shift and turn. Written out: most of the time of a press is spent here.
void add_spring(const Eigen::Vector3d& r, double along, double across, Eigen::Matrix<double, 6, 6>& K) {
  const double x = r.x(), y = r.y(), z = r.z();
  K(0, 0) += along;
  K(1, 1) += across;
  K(2, 2) += across;
  K(3, 1) -= across * z;
  K(3, 2) += across * y;
  K(4, 0) += along * z;
  K(4, 2) -= across * x;
  K(5, 0) -= along * y;
  K(5, 1) += across * x;
  K(3, 3) += across * (y * y + z * z);
  K(4, 4) += along * z * z + across * x * x;
  K(5, 5) += along * y * y + across * x * x;
  K(4, 3) -= across * x * y;
  K(5, 3) -= across * x * z;
  K(5, 4) -= along * y * z;
}

}  // namespace

PadPress::PadPress(const std::vector<SurfaceSample>& surface, const MassProperties& mass,
                   const GripperModel& gripper, const Grasp& grasp)
    : gripper_(gripper),
      weight_(kGravity * mass.mass),
      pads_(1 + gripper.against),
      wanted_{gripper.force, gripper.force / gripper.against, gripper.force / gripper.against} {
  const Pose T_T_O = grasp.T_O_T.inverse();
  const Eigen::Vector3d p_T_M = T_T_O * mass.p_O_M;
  const double spacing = grasp.spacing > 0 ? grasp.spacing : gripper.finger_spacing;
  const double tip = tip_advance(gripper, grasp.opening);
  const double half_open = 0.5 * grasp.opening, half_width = 0.5 * gripper.finger_width;
  for (const SurfaceSample& s : surface) {
    const Eigen::Vector3d p = T_T_O * s.point;
    if (p.z() > tip || p.z() < tip - gripper.pad_length || std::abs(p.x()) < half_open - kReach) continue;
    const double side = p.x() > 0 ? 1.0 : -1.0, facing = side * (T_T_O.linear() * s.normal).x();
    if (facing < kMinFacing) continue;
    for (int f = side > 0 ? 0 : 1; f < (side > 0 ? 1 : pads_); ++f) {
      const double y = f == 0 ? 0.0 : f == 1 ? 0.5 * spacing : -0.5 * spacing;
      if (std::abs(p.y() - y) < half_width) samples_.push_back({p, p - p_T_M, s.area * facing, f});
    }
  }
  squeeze();
}

double PadPress::height(const State& state, const Sample& s) const {
  return kSide[static_cast<std::size_t>(s.pad)] *
         (s.p.x() + state.u[0] + state.u[4] * s.r.z() - state.u[5] * s.r.y());
}

void PadPress::close(State& state, int pad) {
  // The force falls as the pad's place grows: bisection.
  const auto f = static_cast<std::size_t>(pad);
  double high = 0.0;
  met_.clear();
  for (const Sample& s : samples_) {
    if (s.pad != pad) continue;
    met_.push_back({height(state, s), gripper_.pad_stiffness * s.area});
    high = std::max(high, met_.back().height);
  }
  double low = high - kDeepest;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    double force = 0.0;
    for (const auto& [height, stiff] : met_) {
      const double depth = height - middle;
      if (depth > 0) force += stiff * (depth + kBehind * std::max(0.0, depth - gripper_.pad_thickness));
    }
    (force > wanted_[f] ? low : high) = middle;
  }
  state.place[f] = high;
}

PadPress::Vector6 PadPress::forces(const State& state, Matrix6* stiffness) const {
  Vector6 sum = Vector6::Zero();
  if (stiffness != nullptr) stiffness->setZero();
  for (const Sample& s : samples_) {
    const double depth = height(state, s) - state.place[static_cast<std::size_t>(s.pad)];
    if (depth <= 0) continue;
    const double stiff = gripper_.pad_stiffness * s.area,
                 pressed = stiff * std::min(depth, gripper_.pad_thickness);
    const double behind = kBehind * stiff * std::max(0.0, depth - gripper_.pad_thickness);
    const Eigen::Vector3d d = state.u.head<3>() + state.u.tail<3>().cross(s.r);
    Eigen::Vector2d shear = -gripper_.pad_shear * s.area * d.tail<2>();
    const double limit = gripper_.friction * pressed, size = shear.norm();
    const bool slips = size > limit;
    if (slips) shear *= limit / size;
    const Eigen::Vector3d force(-kSide[static_cast<std::size_t>(s.pad)] * (pressed + behind), shear.x(),
                                shear.y());
    sum.head<3>() += force;
    sum.tail<3>() += s.r.cross(force);
    if (stiffness == nullptr) continue;
    const double along = stiff * (behind > 0 ? 1 + kBehind : 1.0);
    const double across = (slips ? kSlipStiffness : 1.0) * gripper_.pad_shear * s.area;
    add_spring(s.r, along, across, *stiffness);
  }
  return sum;
}

bool PadPress::settle(State& state, const Vector6& load) const {
  const double scale = std::max(1.0, load.head<3>().norm());
  Matrix6 K;
  for (int i = 0; i < kIterations; ++i) {
    const Vector6 rest = forces(state, &K) + load;
    if (rest.head<3>().norm() + rest.tail<3>().norm() / kPressLength < kUnbalanced * scale) return true;
    K.diagonal().head<3>().array() += 1.0;  // N/m: keeps a lost stone's step finite
    K.diagonal().tail<3>().array() += 1e-3;
    Vector6 step = K.ldlt().solve(rest);
    const double far = std::max(step.head<3>().norm() / 0.001, step.tail<3>().norm() / 0.02);
    if (far > 1) step /= far;
    state.u += step;
    if (state.u.head<3>().norm() > 2 * kMaxMove || state.u.tail<3>().norm() > 2 * kMaxTurn) return false;
  }
  const Vector6 rest = forces(state, nullptr) + load;
  return rest.head<3>().norm() + rest.tail<3>().norm() / kPressLength < 2 * kUnbalanced * scale;
}

// The fingers close until each has its force; the stone yields meanwhile.
void PadPress::squeeze() {
  for (int round = 0; round < kSqueezeRounds; ++round) {
    for (int f = 0; f < pads_; ++f) close(gripped_, f);
    const Vector6 before = gripped_.u;
    holds_ = settle(gripped_, Vector6::Zero());
    if (!holds_ || (gripped_.u - before).head<3>().norm() < 2e-5) break;
  }
}

double PadPress::deepest(int finger) const {
  double depth = 0.0;
  for (const Sample& s : samples_)
    if (s.pad == finger)
      depth = std::max(depth, height(gripped_, s) - gripped_.place[static_cast<std::size_t>(finger)]);
  return depth;
}

PadPress::Load PadPress::bear(const Eigen::Vector3d& n_T_down, double max) const {
  Load load;
  if (!holds_) return load;
  State state = gripped_;
  for (double share = kLoadStep; share <= max + 1e-9; share += kLoadStep) {
    Vector6 pull = Vector6::Zero();
    pull.head<3>() = share * weight_ * n_T_down;
    if (!settle(state, pull)) break;
    const Vector6 moved = state.u - gripped_.u;
    if (moved.head<3>().norm() > kMaxMove || moved.tail<3>().norm() > kMaxTurn) break;
    load.share = share;
    if (std::abs(share - 1.0) < 1e-9) {
      load.moved = moved.head<3>().norm();
      load.turned = moved.tail<3>().norm();
    }
  }
  return load;
}

}  // namespace stonestack::motion
