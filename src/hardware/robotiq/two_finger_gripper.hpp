#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "hardware/robotiq/modbus.hpp"
#include "hardware/robotiq/robotiq_gripper.hpp"

namespace stonestack::hardware {

/// Robotiq 2F-85, 2F-140 and Hand-E: one register map (instruction manuals, "Control"), reached over Modbus
/// RTU or through the text socket of Robotiq's URCap.
struct TwoFingerOptions {
  std::string link = "urcap";        ///< urcap or rtu
  ModbusOptions modbus;              ///< address and port of the URCap, or device and unit of the line
  double max_opening = 0.085;        ///< distance [m] between the pads at `open_count`
  double open_count = 3.0;           ///< position that is reported when fully open
  double closed_count = 230.0;       ///< position at which the pads meet
  double min_force = 20.0;           ///< [N]
  double max_force = 235.0;          ///< [N]
  double min_speed = 0.020;          ///< of the opening [m/s]
  double max_speed = 0.150;          ///< [m/s]
  double activation_timeout = 20.0;  ///< [s]
  double echo_timeout = 1.0;  ///< time [s] until the gripper must repeat a request; then it is sent once more
  double move_margin = 2.0;   ///< time [s] beyond stroke / speed
  double poll = 0.02;         ///< time [s] between readings of the status
};

/// The status registers, decoded.
struct TwoFingerStatus {
  enum class Stage { kReset, kActivating, kUnused, kReady };
  enum class Object { kMoving, kContactOpening, kContactClosing, kAtRequest };
  bool active = false;
  bool go = false;
  Stage stage = Stage::kReset;
  Object object = Object::kMoving;  ///< valid when `go` is set and `request` repeats the command
  int fault = 0;                    ///< gFLT
  int request = 0;                  ///< position [count] that the gripper repeats
  int position = 0;                 ///< position [count], 0 open
};

/// Command to the gripper; counts of 0 to 255.
struct TwoFingerRequest {
  bool active = true;
  bool go = false;
  int position = 0;
  int speed = 0;
  int force = 0;
};

inline constexpr int kTwoFingerWords = 3;  ///< registers each way
[[nodiscard]] std::vector<std::uint16_t> encode(const TwoFingerRequest& request);
/// Throws InvalidArgument unless there are 3 words.
[[nodiscard]] TwoFingerStatus decode_two_finger_status(const std::vector<std::uint16_t>& words);
/// Fault and remedy of a 2-finger gripper: "fault 0x08: too hot; let it cool down".
/// @return empty for 0.
[[nodiscard]] std::string two_finger_fault_text(int fault);
/// True for a fault that only a new activation ends.
[[nodiscard]] bool is_major_two_finger_fault(int fault);

/// Way to the registers of a gripper. Throws DeviceError when it does not answer in time.
class TwoFingerLink {
 public:
  virtual ~TwoFingerLink() = default;
  [[nodiscard]] virtual TwoFingerStatus read() = 0;
  virtual void write(const TwoFingerRequest& request) = 0;
  /// "Robotiq gripper at 127.0.0.1:63352 (URCap)".
  [[nodiscard]] virtual const std::string& name() const = 0;
};
[[nodiscard]] std::unique_ptr<TwoFingerLink> make_urcap_link(const TwoFingerOptions& options);

/// Connects, moves nothing. Every call is bounded by the time-outs of the options.
class TwoFingerGripper final : public RobotiqGripper {
 public:
  explicit TwoFingerGripper(const TwoFingerOptions& options);

  /// Throws DeviceError when the gripper does not answer; a fault is a value.
  [[nodiscard]] GripperState state() override;
  /// `object`: contact reported while closing, short of the request and of the place where the pads meet.
  /// @throws DeviceError when not activated, on a fault, when the request is not repeated or the fingers do
  /// not come to rest in time, and when something stops them while they open.
  GripperState move(double opening, double speed, double force) override;
  /// There is one finger on each side: nothing to do for 0.
  /// @throws InvalidArgument for another spacing.
  void spread(double spacing) override;
  void activate() override;
  [[nodiscard]] bool is_active() override;
  [[nodiscard]] TwoFingerStatus status() { return link_->read(); }
  [[nodiscard]] const std::string& name() const { return link_->name(); }

 private:
  [[nodiscard]] bool echoes(const TwoFingerStatus& status) const;
  void write(const TwoFingerRequest& request);
  template <class Done>
  TwoFingerStatus wait(double seconds, const std::string& what, const Done& done);
  [[nodiscard]] double opening_at(double count) const;
  [[nodiscard]] int count_for(double opening) const;
  [[nodiscard]] GripperState judge(const TwoFingerStatus& status) const;
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const;

  TwoFingerOptions options_;
  std::unique_ptr<TwoFingerLink> link_;
  TwoFingerRequest last_;
  bool commanded_ = false;
};

}  // namespace stonestack::hardware
