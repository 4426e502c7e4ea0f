#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "hardware/robotiq/modbus.hpp"
#include "hardware/robotiq/robotiq_gripper.hpp"

namespace stonestack::hardware {

/// Robotiq's adaptive 3-finger gripper over Modbus (instruction manual, "Control"; registers of 16 bits, the
/// high byte first).

/// Where the registers lie; differs between firmwares and links.
struct GripperLayout {
  int unit = 2;
  int commands = 0;       ///< first command register
  int status = 0;         ///< first status register
  int read_function = 4;  ///< 3 or 4
};
/// "tcp2018", "tcp2014" or "rtu".
/// @throws InvalidArgument for another name.
[[nodiscard]] GripperLayout gripper_layout(const std::string& preset);

enum class GripperMode { kBasic = 0, kPinch = 1, kWide = 2, kScissor = 3 };

struct ThreeFingerOptions {
  std::string preset = "tcp2018";    ///< register layout: tcp2018, tcp2014 or rtu
  ModbusOptions modbus;              ///< `link` and `unit` follow the preset unless `unit` is given
  int unit = -1;                     ///< -1: of the preset
  std::string mode = "basic";        ///< fingers for `move`: basic, pinch, wide or scissor
  double max_opening = 0.155;        ///< distance [m] between the pads at `open_count`
  double open_count = 0.0;           ///< request that opens fully
  double closed_count = 255.0;       ///< request at which the pads meet
  double narrow_count = 220.0;       ///< of the scissor
  double activation_timeout = 20.0;  ///< [s]
  double echo_timeout = 1.0;  ///< time [s] until the gripper must repeat a request; then it is sent once more
  double move_margin = 2.0;   ///< time [s] beyond stroke / speed
  double poll = 0.02;         ///< time [s] between readings of the status
};
[[nodiscard]] FieldList fields(ThreeFingerOptions& options);

/// The status registers, decoded.
struct ThreeFingerStatus {
  struct Axis {
    enum class Object { kMoving, kContactOpening, kContactClosing, kAtRequest };
    Object object = Object::kMoving;  ///< valid when `go` is set and `request` repeats the command
    int request = 0;                  ///< position [count] that the gripper repeats
    int position = 0;                 ///< position [count], 0 open
    double current = 0.0;             ///< A
  };
  enum class Stage { kReset, kActivating, kModeChange, kReady };
  enum class Motion { kMoving, kSomeStopped, kAllStopped, kAtRequest };
  bool active = false;
  GripperMode mode = GripperMode::kBasic;
  bool go = false;
  Stage stage = Stage::kReset;
  Motion motion = Motion::kMoving;
  int fault = 0;             ///< gFLT
  std::array<Axis, 4> axes;  ///< fingers A, B, C, scissor
};

/// How bad a fault is: nothing, wait and it passes, or activate again.
enum class GripperFaultKind { kNone, kPriority, kMinor, kMajor };
[[nodiscard]] GripperFaultKind gripper_fault_kind(int fault);
/// Fault and remedy: "fault 0x0F: automatic release is complete; activate again".
/// @return empty for 0.
[[nodiscard]] std::string gripper_fault_text(int fault);

/// Request to one axis in individual control; counts, 0 open to 255 closed.
struct FingerRequest {
  int position = 0;
  int speed = 255;  ///< 0 to 255: 22 to 110 mm/s
  int force = 0;    ///< 0 to 255: 15 to 60 N
};

/// Connects, moves nothing. `activate` opens and closes the fingers fully, so it is never called by itself: a
/// stone in the gripper would fall. Every call is bounded by the time-outs of the options.
class ThreeFingerGripper final : public RobotiqGripper {
 public:
  explicit ThreeFingerGripper(const ThreeFingerOptions& options);
  ~ThreeFingerGripper() override;
  ThreeFingerGripper(ThreeFingerGripper&&) noexcept;

  /// Throws DeviceError when the gripper does not answer; a fault is a value.
  [[nodiscard]] GripperState state() override;
  /// Closes or opens all fingers alike. `object` needs both: contact reported while closing, and fingers that
  /// stopped short of the request.
  /// @throws DeviceError when not activated, on a fault, and when the request is not repeated or the fingers
  /// do not come to rest in time.
  GripperState move(double opening, double speed, double force) override;
  /// By individual control of the scissor axis; it stays so in later moves.
  void spread(double spacing) override;

  /// Activates (after a reset when there is a major fault) and takes up the mode of the options. With an
  /// empty gripper only.
  void activate() override;
  [[nodiscard]] bool is_active() override;
  void set_mode(GripperMode mode);
  /// Individual control of fingers A, B, C; with `scissor`, of the scissor too.
  ThreeFingerStatus move_fingers(const std::array<FingerRequest, 3>& fingers,
                                 const std::optional<FingerRequest>& scissor = {});
  /// All registers, decoded.
  [[nodiscard]] ThreeFingerStatus status();
  /// "Robotiq gripper at 127.0.0.1:502 unit 2".
  [[nodiscard]] const std::string& name() const;

 private:
  struct Link;
  std::unique_ptr<Link> link_;
};

}  // namespace stonestack::hardware
