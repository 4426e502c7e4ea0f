#include "hardware/ur/ur_arm.hpp"

#include <cmath>

#include "hardware/constants.hpp"
#include "hardware/ur/run_program.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::hardware {
namespace {

using Status = MotionResult::Status;

constexpr double kPayloadSlack = 0.01;  // kg
constexpr double kCentreSlack = 1e-3;   // m
constexpr double kOffsetSlack = 1e-4;   // m
constexpr double kTurnSlack = 1e-3;     // rad
constexpr double kSettingsTime = 0.5;   // s that a program of settings takes

}  // namespace

struct UrArm::Device {
  Device(const RobotModel& model, const UrArmOptions& options, const Pose& world, const Pose& tool,
         ForceTorqueSensor* sensor)
      : robot(model), T_W_R(world), T_F_T(tool), force_torque(sensor), link(options) {}

  [[nodiscard]] ScriptContext context() {
    ScriptContext c;
    c.version = link.version;
    c.run = link.next_run();
    c.T_F_T = T_F_T;
    c.T_W_R = T_W_R;
    c.payload = payload;
    c.p_F_com = p_F_com;
    c.options = link.options.script;
    return c;
  }

  [[nodiscard]] std::string name() const { return "UR arm at " + link.options.address; }

  /// Why a motion may not start; `now` is where the arm is.
  [[nodiscard]] std::string find_refusal(const UrStatus& now) {
    if (auto hindrance = find_hindrance(now); !hindrance.empty()) return hindrance;
    if (auto reason = link.stop_reason(); !reason.empty())
      return "there was a stop, and nobody has looked and re-armed: " + reason;
    if (now.program_running) return "another program runs on the controller; stop it first";
    if (now.is_held()) return "another program is paused on the controller; stop it first";
    try {
      if (auto other = link.other_safety_configuration(); !other.empty()) return other;
    } catch (const DeviceError& error) {
      return error.what();
    }
    return {};
  }

  /// A link fault during a motion is an end, not an error: the arm has moved.
  MotionResult run(const ProgramOrder& order) {
    try {
      return run_program(link, order);
    } catch (const DeviceError& error) {
      return {Status::kLost, last_q, 0.0, error.what()};
    }
  }

  MotionResult follow(const JointTrajectory& trajectory, const GuardedMotion* guard) {
    const std::unique_lock moving(motion, std::try_to_lock);
    if (!moving) return {Status::kRefused, link.status().q, 0.0, "another motion is in progress"};
    stop_asked = false;
    const UrStatus now = link.next_status();
    last_q = now.q;
    ScriptContext c = context();
    auto refusal = find_refusal(now);
    if (refusal.empty()) refusal = find_fault(trajectory, now.q, robot, c);
    if (refusal.empty() && guard != nullptr && force_torque == nullptr)
      refusal = "a guarded motion needs a force-torque sensor";
    if (!refusal.empty()) return {Status::kRefused, now.q, 0.0, refusal};
    ProgramOrder order{
        {}, c.run, trajectory.duration(), [&](const UrStatus& status) { last_q = status.q; }, &stop_asked};
    if (guard == nullptr) {
      order.script = write_trajectory(trajectory, c);
      return run(order);
    }
    const Pose T_W_B = T_W_R * robot.T_R_D;
    order.script =
        write_guarded(trajectory, {T_W_B.rotation().transpose() * guard->n_W_direction, guard->threshold}, c);
    double last_reading = -1.0;
    order.each_turn = [&](const UrStatus& status) {
      last_q = status.q;
      stream_force(status, last_reading);
    };
    return run(order);
  }

  /// A reading is passed on once, so that the controller's counter shows a sensor that has gone silent.
  void stream_force(const UrStatus& status, double& last_reading) {
    const Wrench wrench = force_torque->read();
    if (wrench.device_time == last_reading) return;
    last_reading = wrench.device_time;
    if (!wrench.force.allFinite())
      throw DeviceError("force-torque sensor", "reads a force that is not finite", "look at the sensor");
    const Pose T_B_F = robot.T_R_D.inverse() * forward(robot, status.q);
    link.send_force(T_B_F.rotation() * wrench.force);
  }

  void check_settings() {
    const RtdeSample sample = link.rtde.wait_for_next(Deadline::in(0.5)).value_or(link.rtde.sample());
    if (sample.has("payload") && std::abs(sample.get<double>("payload") - *payload) > kPayloadSlack)
      throw DeviceError(
          name(), concat("reads back a payload of ", sample.get<double>("payload"), " kg, not ", *payload),
          "look at the installation on the pendant");
    if (sample.has("payload_cog") && *payload > kPayloadSlack) {  // of nothing, a centre means nothing
      const Eigen::Vector3d read(sample.get<std::array<double, 3>>("payload_cog").data());
      if ((read - p_F_com).norm() > kCentreSlack)
        throw DeviceError(name(),
                          concat("reads back a payload's centre at (", read.transpose(), ") m, not (",
                                 p_F_com.transpose(), ")"),
                          "look at the installation on the pendant");
    }
    if (sample.has("tcp_offset")) check_tool(sample.get<std::array<double, 6>>("tcp_offset"));
  }

  /// `offset` as UR writes a pose: place, then axis times angle.
  void check_tool(const std::array<double, 6>& offset) const {
    const Eigen::Vector3d place(offset.data()), turn(offset.data() + 3);
    const Eigen::AngleAxisd read(turn.norm(), turn.norm() > 0 ? turn.normalized() : Eigen::Vector3d::UnitZ());
    const Eigen::AngleAxisd wanted(T_F_T.rotation());
    const double off = Eigen::AngleAxisd(read.toRotationMatrix().transpose() * T_F_T.rotation()).angle();
    if ((place - T_F_T.translation()).norm() <= kOffsetSlack && off <= kTurnSlack) return;
    throw DeviceError(name(),
                      concat("reads back a tool at (", place.transpose(), ") m turned by (", turn.transpose(),
                             ") rad, not (", T_F_T.translation().transpose(), ") m turned by (",
                             (wanted.angle() * wanted.axis()).transpose(), ") rad"),
                      "look at the installation on the pendant");
  }

  RobotModel robot;
  Pose T_W_R, T_F_T;
  ForceTorqueSensor* force_torque;
  std::mutex motion;  // one motion at a time; guards the next three
  std::optional<double> payload;
  Eigen::Vector3d p_F_com = Eigen::Vector3d::Zero();
  Joints last_q = Joints::Zero();  // as the latest motion has seen it
  std::atomic<bool> stop_asked{false};
  UrLink link;
};

UrArm::UrArm(const RobotModel& robot, const UrArmOptions& options, const Pose& T_W_R, const Pose& T_F_T,
             ForceTorqueSensor* force_torque)
    : device_(std::make_unique<Device>(robot, options, T_W_R, T_F_T, force_torque)) {}

UrArm::~UrArm() = default;

ArmState UrArm::state() {
  const UrStatus now = device_->link.status();
  ArmState state;
  state.q = now.q;
  state.qd = now.qd;
  state.device_time = now.device_time;
  state.host_time = now.host_time;
  state.speed_scaling = now.speed;
  state.stop_reason = find_hindrance(now);
  if (state.stop_reason.empty()) state.stop_reason = device_->link.stop_reason();
  state.can_move = state.stop_reason.empty();
  return state;
}

MotionResult UrArm::follow(const JointTrajectory& trajectory) {
  return device_->follow(trajectory, nullptr);
}

MotionResult UrArm::follow_guarded(const GuardedMotion& motion) {
  require(motion.threshold > 0 && std::abs(motion.n_W_direction.norm() - 1) < 1e-6,
          "a guard needs a positive threshold and a unit direction, got ", motion.threshold, " N and length ",
          motion.n_W_direction.norm());
  return device_->follow(motion.trajectory, &motion);
}

void UrArm::stop() {
  device_->stop_asked = true;  // before the stop is sent: no program follows it
  const int stop = send_stop(device_->link);
  const Deadline deadline = Deadline::in(device_->link.options.stop_timeout);
  while (!deadline.over()) {
    const bool in_transit = device_->link.program_in_transit;  // read before the status in which it ends
    const UrStatus now = device_->link.next_status();
    if (!find_safety_stop(now).empty()) return;   // the safety system has stopped it
    if (in_transit && now.run != stop) continue;  // a program may yet start
    if (!now.program_running && !now.is_held() && now.qd.cwiseAbs().maxCoeff() < kStandstillSpeed) return;
  }
  device_->link.starve("a stop was not obeyed");
  throw DeviceError(device_->name(),
                    concat("does not stand ", device_->link.options.stop_timeout, " s after a stop"),
                    "press the emergency stop");
}

void UrArm::set_payload(double mass, const Eigen::Vector3d& p_F_com) {
  require(std::isfinite(mass) && mass >= 0 && p_F_com.allFinite(),
          "a payload needs a mass and a finite centre, got ", mass, " kg");
  require(mass <= device_->robot.payload, "the arm carries ", device_->robot.payload, " kg, not ", mass,
          " kg");
  const std::unique_lock moving(device_->motion, std::try_to_lock);
  if (!moving) throw DeviceError(device_->name(), "is moving", "set the payload at rest");
  if (auto refusal = device_->find_refusal(device_->link.next_status()); !refusal.empty())
    throw DeviceError(device_->name(), "takes no payload: " + refusal, "look at the pendant");
  device_->payload = mass;
  device_->p_F_com = p_F_com;
  device_->stop_asked = false;
  const ScriptContext context = device_->context();
  const MotionResult set = run_program(
      device_->link, {write_settings(context), context.run, kSettingsTime, {}, &device_->stop_asked});
  if (set.status != Status::kDone)
    throw DeviceError(device_->name(), "takes no payload: " + set.reason, "look at the pendant");
  device_->check_settings();
}

void UrArm::rearm() {
  device_->link.rearm();
}

UrVersion UrArm::version() const {
  return device_->link.version;
}

std::optional<std::uint32_t> UrArm::safety_checksum() const {
  return device_->link.wait_for_safety_checksum();
}

std::vector<std::string> UrArm::missing_outputs() const {
  return device_->link.rtde.missing();
}

FieldList fields(UrArmOptions& o) {
  constexpr FieldRange kPort{0, 65535};
  return join(
      {{user(field("address", o.address, "of the controller, or its name in the network")),
        field("rtde_port", o.rtde_port, kPort, "", "RTDE"),
        field("primary_port", o.primary_port, kPort, "", "scripts"),
        field("secondary_port", o.secondary_port, kPort, "", "scripts, tried next"),
        field("realtime_port", o.realtime_port, kPort, "", "scripts, tried last; 0 leaves a port out"),
        field("dashboard_port", o.dashboard_port, kPort, "", "Dashboard server"),
        field("start_timeout", o.start_timeout, {0.1, 60}, "s", "until a program reports that it runs"),
        field("end_grace", o.end_grace, {0.05, 10}, "s", "that a program may be over without an end state"),
        field("time_slack", o.time_slack, {0.1, 600}, "s", "that a motion may take longer than planned"),
        field("pause_limit", o.pause_limit, {0, 86400}, "s", "that a user may pause a motion"),
        field("stop_timeout", o.stop_timeout, {0.1, 60}, "s", "until the arm stands still after a stop"),
        field("safety_checksum", o.safety_checksum,
              "of the safety configuration with which the arm may move, as `setup` writes it; empty: any"),
        field("serial", o.serial, "of the arm that may be moved, as `setup` writes it; empty: any")},
       nest("rtde", fields(o.rtde)),
       nest("script", fields(o.script))});
}

}  // namespace stonestack::hardware
