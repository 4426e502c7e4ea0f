#include "simulation/finger_pad.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::simulation {
namespace {

constexpr double kMinFacing = 0.2;  // cosine: steeper surface lies beside the pad, not on it
constexpr double kEdge = 0.001;     // m past the rectangle until a bristle lets go

// How far a point of the stone may have moved in P since then.
double max_move(const Pose& now, const Pose& then, const ContactShape& shape) {
  const Eigen::Vector3d& p = shape.mass.p_O_M;
  const double turn = Eigen::AngleAxisd(now.rotation() * then.rotation().transpose()).angle();
  return (now * p - then * p).norm() + std::abs(turn) * shape.radius;
}

}  // namespace

void PadContact::collect(const Pose& T_P_O) {
  std::vector<Bristle> found;
  auto old = bristles_.cbegin();
  const double x = 0.5 * options_.length + kReach, y = 0.5 * options_.width + kReach;
  const double behind = options_.thickness + kReach;
  for (std::size_t i = 0; i < shape_->samples.size(); ++i) {
    const int sample = static_cast<int>(i);
    const Eigen::Vector3d p_P = T_P_O * shape_->samples[i].point;
    if (std::abs(p_P.x()) > x || std::abs(p_P.y()) > y || p_P.z() < -behind || p_P.z() > kReach) continue;
    while (old != bristles_.cend() && old->sample < sample) ++old;
    const bool known = old != bristles_.cend() && old->sample == sample;
    found.push_back(known ? *old : Bristle{sample});
  }
  bristles_ = std::move(found);
  T_P_O_collected_ = T_P_O;
  collected_ = true;
}

bool PadContact::near(const Pose& T_W_P, const Pose& T_W_O) {
  const Pose T_P_O = T_W_P.inverse() * T_W_O;
  const double reach = std::hypot(0.5 * options_.length, 0.5 * options_.width) + kReach;
  if ((T_P_O * shape_->mass.p_O_M).norm() > shape_->radius + reach + options_.thickness) {
    bristles_.clear();
    collected_ = touching_ = false;
    return false;
  }
  if (!collected_ || max_move(T_P_O, T_P_O_collected_, *shape_) > 0.5 * kReach) collect(T_P_O);
  return !bristles_.empty();
}

PadLoad PadContact::press(const MovingFrame& pad, const MovingFrame& stone) {
  PadLoad load;
  const Pose T_P_W = pad.T_W_A.inverse(), T_P_O = T_P_W * stone.T_W_A;
  for (auto& bristle : bristles_) {
    const auto& sample = shape_->samples[static_cast<std::size_t>(bristle.sample)];
    const Eigen::Vector3d p_P = T_P_O * sample.point;
    const double depth = -p_P.z(), facing = -(T_P_O.linear() * sample.normal).z();
    const double slack = bristle.active ? kEdge : 0.0;
    const bool inside = depth > 0 && std::abs(p_P.x()) < 0.5 * options_.length + slack &&
                        std::abs(p_P.y()) < 0.5 * options_.width + slack && facing > kMinFacing;
    if (!inside || (!bristle.active && depth > options_.thickness)) {
      bristle.active = false;
      continue;
    }
    if (!bristle.active) {
      bristle = {bristle.sample, true, depth > options_.entry_depth ? depth : 0.0, p_P.head<2>()};
    }
    const double area = sample.area * facing;
    const Eigen::Vector3d p_W = pad.T_W_A * p_P;
    const Eigen::Vector3d v_P = T_P_W.linear() * (stone.velocity_at(p_W) - pad.velocity_at(p_W));
    const double elastic = std::max(0.0, options_.stiffness * (depth - bristle.rest));
    const double pressure =
        elastic > 0 ? std::max(0.0, elastic - options_.stiffness * options_.damping * v_P.z()) : 0.0;
    const double limit = options_.friction * pressure;
    Eigen::Vector2d stretch = p_P.head<2>() - bristle.anchor;
    if (options_.shear * stretch.norm() > limit) {  // slips: the bristle's base is dragged along
      stretch *= limit / (options_.shear * stretch.norm());
      bristle.anchor = p_P.head<2>() - stretch;
    }
    Eigen::Vector2d friction = -options_.shear * (stretch + options_.damping * v_P.head<2>());
    if (friction.norm() > limit) friction *= limit / friction.norm();
    const Eigen::Vector3d force =
        area * (pad.T_W_A.linear() * Eigen::Vector3d(friction.x(), friction.y(), pressure));
    load.force += force;
    load.moment += p_W.cross(force);
    load.normal += area * elastic;
    ++load.samples;
  }
  touching_ = load.samples > 0;
  return load;
}

}  // namespace stonestack::simulation
