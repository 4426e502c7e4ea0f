#include "simulation/ur/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr double kEquivalentRadius =
    0.25;  // m, compares turning with moving; as in the configuration package
constexpr double kTiny = 1e-9;
constexpr double kOverspeed = 1.02;        // of a joint's limit: what stops the arm
constexpr double kPressGain = 0.002;       // m/s a N
constexpr double kTurnGain = 0.02;         // rad/s a Nm
constexpr double kMostAcceleration = 100;  // rad/s^2 or m/s^2: what scripts may ask for

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d turned(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < kTiny) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

double bounded(double value, double most) {
  return std::clamp(value, 1e-3, most);
}

}  // namespace

Motion::Motion(const RobotModel& robot, const Joints& q)
    : geometry_(robot), q_(q), q_start_(q), q_unpressed_(q) {}

Pose Motion::compose(const Pose& start, const Six& way) const {
  Pose pose = start;
  pose.translation() += way.head<3>();
  pose.linear() = turned(way.tail<3>()) * start.rotation();
  return pose;
}

Six Motion::corner() const {
  Six sum = Six::Zero();
  for (const auto& move : moves_) sum += move.way;
  return sum;
}

// Goes on from moves that blend into the next; anything else that still moves is braked beside it.
void Motion::begin_moves(bool line, double acceleration) {
  const bool blends = mode_ == Mode::kMoves && line == line_ && !moves_.empty() && moves_.back().blend > 0;
  if (blends) return;
  Six speed = qd_;
  if (line) speed = geometry_.twist(q_unpressed_, qd_);
  moves_.clear();
  mode_ = Mode::kMoves;
  line_ = line;
  q_start_ = q_unpressed_;
  T_B_start_ = geometry_.T_B_P(q_unpressed_);
  const double fastest = speed.cwiseAbs().maxCoeff();
  if (fastest < 1e-6) return;
  const Profile brake = make_brake(fastest, acceleration);
  moves_.push_back({speed / fastest * brake.length, brake, 0.0, 0.0});
}

void Motion::push(const Six& way, double length, const MoveOptions& options, double blend) {
  const double a = bounded(options.acceleration, kMostAcceleration);
  Move move;
  move.way = way;
  if (length > kTiny)
    move.profile = options.seconds > 0 ? make_timed_profile(length, options.seconds)
                                       : make_profile(length, bounded(options.speed, 100.0), a);
  move.blend = std::min(blend, 0.5 * length);
  moves_.push_back(move);
}

void Motion::move_joints(const Joints& q, const MoveOptions& options) {
  begin_moves(false, bounded(options.acceleration, kMostAcceleration));
  const Joints start = q_start_ + corner();
  const Joints way = q - start;
  MoveOptions limited = options;
  const Joints& fastest = geometry_.robot().velocity;
  const double length = way.cwiseAbs().maxCoeff();
  for (int j = 0; j < 6; ++j)
    if (std::abs(way[j]) > kTiny)
      limited.speed = std::min(limited.speed, fastest[j] * length / std::abs(way[j]));
  // A blend radius is a distance of the tool: how much of the joint way that is.
  const double tool_way = (geometry_.T_B_P(q).translation() - geometry_.T_B_P(start).translation()).norm();
  push(way, length, limited, tool_way > kTiny ? options.blend / tool_way * length : 0.0);
}

void Motion::move_line(const Pose& T_B_P, const MoveOptions& options) {
  begin_moves(true, bounded(options.acceleration, kMostAcceleration));
  Pose start = T_B_start_;
  for (const auto& move : moves_) start = compose(start, move.way);
  Six way;
  way << T_B_P.translation() - start.translation(),
      rotation_vector(T_B_P.rotation() * start.rotation().transpose());
  const double length = std::max(way.head<3>().norm(), kEquivalentRadius * way.tail<3>().norm());
  push(way, length, options, options.blend);
}

void Motion::move_arc(const Pose& via, const Pose& T_B_P, const MoveOptions& options) {
  move_line(T_B_P, options);
  auto& move = moves_.back();
  const Eigen::Vector3d p1 = T_B_P.translation();
  const Eigen::Vector3d p0 = p1 - move.way.head<3>();
  const Eigen::Vector3d u = via.translation() - p0, w = p1 - p0;
  const Eigen::Vector3d n = u.cross(w);
  if (n.squaredNorm() < 1e-14) return;
  // Circumcentre of the triangle, seen from p0.
  const Eigen::Vector3d centre =
      (u.squaredNorm() * w.cross(n) + w.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
  const auto angle_to = [&](const Eigen::Vector3d& p) {
    const double angle =
        std::atan2(n.normalized().dot((-centre).cross(p - centre)), (-centre).dot(p - centre));
    return angle < 0 ? angle + 2 * std::numbers::pi : angle;
  };
  const double angle = angle_to(w);
  move.n_B_arc = angle * n.normalized();
  move.p_B_spoke = -centre;
  const Six way = move.way;
  const double length = std::max(angle * centre.norm(), kEquivalentRadius * way.tail<3>().norm());
  const Move arc = move;
  moves_.pop_back();
  push(way, length, options, options.blend);
  moves_.back().n_B_arc = arc.n_B_arc;
  moves_.back().p_B_spoke = arc.p_B_spoke;
}

Six Motion::Move::way_at(double share) const {
  Six part = share * way;
  if (!n_B_arc.isZero()) part.head<3>() = turned(share * n_B_arc) * p_B_spoke - p_B_spoke;
  return part;
}

void Motion::servo(const Joints& q, double seconds, double lookahead, double gain) {
  mode_ = Mode::kServo;
  moves_.clear();
  servo_target_ = q;
  servo_lag_ = std::clamp(lookahead, 0.03, 0.2) + 4.0 / std::clamp(gain, 100.0, 2000.0);
  elapsed_ = 0.0;
  hold_ = seconds;
}

void Motion::begin_speed(bool line, const Six& target, double acceleration, double seconds) {
  if (mode_ != Mode::kSpeed || line_ != line) {
    speed_ = qd_;
    if (line) speed_ = geometry_.twist(q_unpressed_, qd_);
    T_B_speed_ = geometry_.T_B_P(q_unpressed_);
  }
  moves_.clear();
  mode_ = Mode::kSpeed;
  line_ = line;
  speed_target_ = target;
  speed_acceleration_ = bounded(acceleration, 1000.0);
  elapsed_ = 0.0;
  hold_ = seconds;
}

void Motion::speed_joints(const Joints& qd, double acceleration, double seconds) {
  begin_speed(false, qd, acceleration, seconds);
}

void Motion::speed_line(const Six& twist, double acceleration, double seconds) {
  begin_speed(true, twist, acceleration, seconds);
}

void Motion::stop_joints(double acceleration) {
  begin_speed(false, Six::Zero(), acceleration, -1.0);
}

void Motion::stop_line(double acceleration) {
  begin_speed(true, Six::Zero(), acceleration, -1.0);
}

void Motion::freeze() {
  mode_ = Mode::kRest;
  moves_.clear();
  speed_.setZero();
  qd_.setZero();
  qdd_.setZero();
  force_.active = false;
  shift_.setZero();
  q_unpressed_ = q_;
}

void Motion::set_force_mode(const ForceMode& mode) {
  if (!mode.active) {
    shift_.setZero();
    q_unpressed_ = q_;
    if (mode_ != Mode::kSpeed) mode_ = Mode::kRest;
    moves_.clear();
    T_B_speed_ = geometry_.T_B_P(q_);
  }
  force_ = mode;
}

bool Motion::moving() const {
  return qd_.cwiseAbs().maxCoeff() > 1e-6;
}

bool Motion::done() const {
  switch (mode_) {
    case Mode::kRest:
      return true;
    case Mode::kMoves: {
      if (moves_.empty()) return true;
      const auto& move = moves_.back();
      return move.profile.length - move.profile.way(move.t) <= move.blend + kTiny;
    }
    case Mode::kServo:
      return elapsed_ >= hold_ - kTiny;
    case Mode::kSpeed:
      return hold_ >= 0 ? elapsed_ >= hold_ - kTiny : speed_ == speed_target_;
  }
  return true;
}

bool Motion::next_moves(double seconds, Joints& q) {
  Six sum = Six::Zero();
  Pose pose = T_B_start_;
  bool all_over = true;
  for (auto& move : moves_) {
    move.t += seconds;
    const double share = move.profile.length > kTiny ? move.profile.way(move.t) / move.profile.length : 1.0;
    sum += share * move.way;
    pose = compose(pose, move.way_at(share));
    all_over = all_over && move.t >= move.profile.duration();
  }
  q = q_start_ + sum;
  if (line_ && !geometry_.inverse(pose, q_unpressed_, true, q)) return false;
  if (all_over) {
    mode_ = Mode::kRest;
    moves_.clear();
  }
  return true;
}

bool Motion::next_servo(double seconds, Joints& q) {
  const double w = 2.0 / servo_lag_;
  // Exact step of q'' = w^2 (target - q) - 2 w q'.
  const Joints error = q_unpressed_ - servo_target_;
  const double decay = std::exp(-w * seconds);
  q = servo_target_ + decay * (error + seconds * (qd_ + w * error));
  elapsed_ += seconds;
  return true;
}

bool Motion::next_speed(double seconds, Joints& q) {
  const Six change = speed_target_ - speed_;
  const double largest = change.cwiseAbs().maxCoeff();
  const double most = speed_acceleration_ * seconds;
  const Six before = speed_;
  speed_ = largest <= most ? speed_target_ : Six(speed_ + change * (most / largest));
  const Six way = 0.5 * seconds * (before + speed_);
  elapsed_ += seconds;
  q = q_unpressed_ + way;
  if (!line_) return true;
  T_B_speed_ = compose(T_B_speed_, way);
  return geometry_.inverse(T_B_speed_, q_unpressed_, true, q);
}

// Compliant axes give way until what presses on the tool balances what the tool shall press with.
bool Motion::press(double seconds, const Six& wrench_B, Joints& q) {
  const Eigen::Matrix3d R = force_.T_B_task.rotation();
  Six felt, speed = Six::Zero();
  felt << R.transpose() * wrench_B.head<3>(), R.transpose() * wrench_B.tail<3>();
  for (int i = 0; i < 6; ++i)
    if (force_.selection[i] != 0)
      speed[i] = std::clamp((i < 3 ? kPressGain : kTurnGain) * (force_.wrench[i] + felt[i]),
                            -std::abs(force_.limits[i]), std::abs(force_.limits[i]));
  shift_.head<3>() += seconds * (R * speed.head<3>());
  shift_.tail<3>() += seconds * (R * speed.tail<3>());
  return geometry_.inverse(compose(geometry_.T_B_P(q), shift_), q_, true, q);
}

std::string Motion::judge(const Joints& q, double seconds) const {
  const auto& robot = geometry_.robot();
  for (int j = 0; j < 6; ++j) {
    const double speed = std::abs(q[j] - q_[j]) / seconds;
    if (!std::isfinite(q[j])) return concat("joint ", j + 1, " has no finite target");
    if (q[j] > robot.upper[j] + 1e-6 || q[j] < robot.lower[j] - 1e-6)
      return concat("joint ", j + 1, " at its position limit (", q[j], " rad)");
    if (speed > kOverspeed * robot.velocity[j])
      return concat("joint ", j + 1, " faster than its limit (", speed, " rad/s)");
  }
  return {};
}

std::string Motion::step(double seconds, const Six& wrench_B) {
  Joints q = q_unpressed_;
  bool reached = true;
  if (seconds <= kTiny) {
    qd_.setZero();
    qdd_.setZero();
    return {};
  }
  if (mode_ == Mode::kMoves) reached = next_moves(seconds, q);
  if (mode_ == Mode::kServo) reached = next_servo(seconds, q);
  if (mode_ == Mode::kSpeed) reached = next_speed(seconds, q);
  if (!reached) return "the target is out of reach or too close to a singularity";
  const Joints unpressed = q;
  if (force_.active && !press(seconds, wrench_B, q)) return "force mode leaves the reach";
  if (auto reason = judge(q, seconds); !reason.empty()) return reason;
  const Joints qd = (q - q_) / seconds;
  qdd_ = (qd - qd_) / seconds;
  // A servo's filter needs its own speed at the step's end, not the mean over the step.
  if (mode_ == Mode::kServo) {
    const double w = 2.0 / servo_lag_, decay = std::exp(-w * seconds);
    const Joints error = q_unpressed_ - servo_target_;
    qd_ = decay * (qd_ - w * seconds * (qd_ + w * error));
  } else if (mode_ == Mode::kSpeed && !line_) {
    qd_ = speed_;
  } else {
    qd_ =
        mode_ == Mode::kRest && !force_.active ? Joints(Joints::Zero()) : qd;  // a move's last, partial step
  }
  q_unpressed_ = unpressed;
  q_ = q;
  return {};
}

}  // namespace stonestack
