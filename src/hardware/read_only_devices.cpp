#include "hardware/read_only_devices.hpp"

#include <utility>

#include "hardware/cell_config.hpp"
#include "hardware/ur/joint_reader.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

[[noreturn]] void refuse_command(const char* command) {
  throw InvalidArgument(concat("devices that are only read were told to ", command));
}

class ReadOnlyArm final : public Arm {
 public:
  explicit ReadOnlyArm(std::function<ArmState()> read) : read_(std::move(read)) {}
  [[nodiscard]] ArmState state() override { return read_(); }
  [[nodiscard]] MotionResult follow(const JointTrajectory& /*trajectory*/) override {
    refuse_command("move the arm");
  }
  [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& /*motion*/) override {
    refuse_command("move the arm");
  }
  void stop() override {}
  void set_payload(double /*mass*/, const Eigen::Vector3d& /*p_F_com*/) override {
    refuse_command("set a payload");
  }

 private:
  std::function<ArmState()> read_;
};

class ReadOnlyGripper final : public Gripper {
 public:
  [[nodiscard]] GripperState state() override { return {}; }
  GripperState move(double /*opening*/, double /*speed*/, double /*force*/) override {
    refuse_command("move the fingers");
  }
  void spread(double /*spacing*/) override { refuse_command("spread the fingers"); }
};

class ReadOnlySensor final : public ForceTorqueSensor {
 public:
  [[nodiscard]] Wrench read() override { refuse_command("measure a force"); }
  void zero() override { refuse_command("take a zero"); }
};

}  // namespace

struct ReadOnlyDevices::Parts {
  ReadOnlyArm arm;
  ReadOnlyGripper gripper;
  ReadOnlySensor force_torque;
  DepthCamera& camera;
  Clock& clock;
  CellLayout layout;
};

ReadOnlyDevices::ReadOnlyDevices(std::function<ArmState()> arm_state, DepthCamera& camera, Clock& clock,
                                 CellLayout layout)
    : parts_(new Parts{ReadOnlyArm(std::move(arm_state)), {}, {}, camera, clock, std::move(layout)}) {}

ReadOnlyDevices::~ReadOnlyDevices() = default;

Cell ReadOnlyDevices::cell() {
  Parts& p = *parts_;
  return {p.arm, p.gripper, p.force_torque, p.camera, p.clock, p.layout};
}

struct ReadOnlyHardware::Parts {
  JointReader joints;
  std::unique_ptr<DepthCamera> camera;
  std::unique_ptr<Clock> clock = make_steady_clock();
  ReadOnlyDevices devices;

  explicit Parts(const CellConfig& config)
      : joints(config.arm),
        camera(make_camera(config)),
        devices(
            [this] {
              const JointReading reading = joints.read();
              ArmState state;
              state.q = reading.q;
              state.device_time = reading.device_time;
              return state;
            },
            *camera, *clock, to_layout(config)) {}
};

ReadOnlyHardware::ReadOnlyHardware(const CellConfig& config) {
  require_arm_address(config);
  parts_ = std::make_unique<Parts>(config);
}

ReadOnlyHardware::~ReadOnlyHardware() = default;

Cell ReadOnlyHardware::cell() {
  return parts_->devices.cell();
}

}  // namespace stonestack::hardware
