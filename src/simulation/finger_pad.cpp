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
  note_points();
  T_P_O_collected_ = T_P_O;
  collected_ = true;
}

void PadContact::note_points() {
  x_O_.clear(), y_O_.clear(), z_O_.clear();
  for (const Bristle& bristle : bristles_) {
    const Eigen::Vector3d& p_O = shape_->samples[static_cast<std::size_t>(bristle.sample)].point;
    x_O_.push_back(p_O.x()), y_O_.push_back(p_O.y()), z_O_.push_back(p_O.z());
  }
  depth_.resize(bristles_.size());
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

// Velocities, forces and moments are those of the pad's frame P until they have been added up.
PadLoad PadContact::press(const MovingFrame& pad, const MovingFrame& stone) {
  const Pose T_P_W = pad.T_W_A.inverse(), T_P_O = T_P_W * stone.T_W_A;
  const Eigen::Vector3d p_W_P = pad.T_W_A.translation();
  const Eigen::Vector3d v_P = T_P_W.linear() * (stone.velocity_at(p_W_P) - pad.velocity_at(p_W_P));
  const Eigen::Vector3d w_P = T_P_W.linear() * (stone.twist.w - pad.twist.w);
  const Eigen::Vector3d n_O_P = T_P_O.linear().row(2).transpose();  // the pad's normal, in O
  const double z_P_O = T_P_O.translation().z();
  const PadOptions options = options_;
  const double half_length = 0.5 * options.length, half_width = 0.5 * options.width;
  Eigen::Vector3d force_P = Eigen::Vector3d::Zero(), moment_P = Eigen::Vector3d::Zero();
  double normal = 0.0;
  int samples = 0;
  for (std::size_t k = 0; k < bristles_.size(); ++k)  // several at once: most are not in the pad
    depth_[k] = -(n_O_P.x() * x_O_[k] + (n_O_P.y() * y_O_[k] + n_O_P.z() * z_O_[k]) + z_P_O);
  for (std::size_t k = 0; k < bristles_.size(); ++k) {
    Bristle& bristle = bristles_[k];
    const double depth = depth_[k];
    if (!(depth > 0)) {
      bristle.active = false;
      continue;
    }
    const auto& sample = shape_->samples[static_cast<std::size_t>(bristle.sample)];
    const Eigen::Vector3d p_P = T_P_O * sample.point;
    const double slack = bristle.active ? kEdge : 0.0, facing = -n_O_P.dot(sample.normal);
    if (facing <= kMinFacing || std::abs(p_P.x()) >= half_length + slack ||
        std::abs(p_P.y()) >= half_width + slack || (!bristle.active && depth > options.thickness)) {
      bristle.active = false;
      continue;
    }
    if (!bristle.active) {
      bristle = {bristle.sample, true, depth > options.entry_depth ? depth : 0.0, p_P.head<2>()};
    }
    const Eigen::Vector3d v = v_P + w_P.cross(p_P);
    const double elastic = std::max(0.0, options.stiffness * (depth - bristle.rest));
    const double pressure =
        elastic > 0 ? std::max(0.0, elastic - options.stiffness * options.damping * v.z()) : 0.0;
    const double limit = options.friction * pressure;
    Eigen::Vector2d stretch = p_P.head<2>() - bristle.anchor;
    const double shear = options.shear * options.shear * stretch.squaredNorm();
    if (shear > limit * limit) {  // slips: the bristle's base is dragged along
      stretch *= limit / std::sqrt(shear);
      bristle.anchor = p_P.head<2>() - stretch;
    }
    Eigen::Vector2d friction = -options.shear * (stretch + options.damping * v.head<2>());
    if (friction.squaredNorm() > limit * limit) friction *= limit / friction.norm();
    const double area = sample.area * facing;
    const Eigen::Vector3d force(area * friction.x(), area * friction.y(), area * pressure);
    force_P += force;
    moment_P += p_P.cross(force);
    normal += area * elastic;
    ++samples;
  }
  touching_ = samples > 0;
  PadLoad load;
  load.force = pad.T_W_A.linear() * force_P;
  load.moment = pad.T_W_A.linear() * moment_P + p_W_P.cross(load.force);
  load.normal = normal;
  load.samples = samples;
  return load;
}

}  // namespace stonestack::simulation
