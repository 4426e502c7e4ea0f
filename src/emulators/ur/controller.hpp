#pragma once
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <optional>

#include "core/socket.hpp"
#include "emulators/ur/motion.hpp"
#include "emulators/ur/ur_controller_server.hpp"
#include "protocol/rtde_fields.hpp"
#include "urscript/machine.hpp"

namespace stonestack::emulators {

enum class RobotMode { kPowerOff = 3, kPowerOn = 4, kIdle = 5, kBackdrive = 6, kRunning = 7 };
enum class SafetyMode { kNormal = 1, kProtectiveStop = 3, kRobotEmergencyStop = 7, kFault = 9 };
/// Pausing lasts until the arm has been braked to rest, resuming until it moves again.
enum class RuntimeState {
  kStopping = 0,
  kStopped = 1,
  kPlaying = 2,
  kPausing = 3,
  kPaused = 4,
  kResuming = 5
};

/// The general purpose registers, as RTDE and scripts share them.
struct Registers {
  std::array<std::int32_t, 48> in_int{}, out_int{};
  std::array<double, 48> in_double{}, out_double{};
  std::array<bool, 128> in_bit{}, out_bit{};

  /// An integer of a script, written during that control step.
  void write_int(std::size_t i, std::int32_t value, std::uint64_t step);
  /// State that RTDE shows after that step. It looks while scripts run: now and then at what a script wrote
  /// and wrote over again within the step.
  [[nodiscard]] std::int32_t seen_int(std::size_t i, std::uint64_t step) const;

 private:
  struct Write {
    std::uint64_t step = 0, over_step = 0;
    std::int32_t over = 0;
  };
  std::array<Write, 48> writes_{};
};

struct ControllerIo {
  std::uint64_t digital_in = 0, digital_out = 0;  ///< 0-7 standard, 8-15 configurable, 16-17 tool
  std::array<double, 2> analog_out{};
  std::uint32_t analog_out_types = 3;  ///< volts
  int tool_voltage = 0;
};

/// Event for primary clients.
struct ControllerEvent {
  enum class Kind { kKey, kText, kRuntimeException, kErrorCode, kSafetyMode, kPopup };
  Kind kind = Kind::kText;
  std::string title, text;
  int code = 0, argument = 0, level = 0;
  int line = 0, column = 0;
  bool warning = false, error = false, blocking = false;
};

/// A script as the controller understands it, or why it does not.
struct CompiledScript {
  std::optional<urscript::Program> program;
  urscript::CompileError error;
};

/// rtde_set_watchdog.
struct Watchdog {
  std::string variable;
  double period = 0.0;  ///< 0 [s]: off
  std::string action;
  double fed = 0.0;  ///< [s]
};

/// A connection that a script has opened to somebody else.
struct ScriptSocket {
  TcpStream stream;
  std::string received;
  bool closed = false;
};

/// The controller without its sockets: state, programs, motion. Not thread-safe.
class UrController : public urscript::Host {
 public:
  UrController(const UrServerOptions& options, const RobotModel& robot, Plant& plant);

  /// One control step.
  void step();
  [[nodiscard]] double period() const { return period_; }
  /// Seconds since the controller was switched on, on the control step.
  [[nodiscard]] double timestamp() const { return start_ + static_cast<double>(steps_) * period_; }
  /// Seconds since it was made.
  [[nodiscard]] double uptime() const { return static_cast<double>(steps_) * period_; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

  /// One program or statement as a script port takes it. The running program goes on when it cannot be
  /// compiled.
  void run_script(const std::string& source);
  /// The two halves of it. Compiling changes nothing and may be done in another thread, beside the steps.
  [[nodiscard]] CompiledScript compile(const std::string& source) const;
  void run(CompiledScript script);
  void stop_program();
  /// The Dashboard's loaded program: runs until it is stopped. False when there is none or it may not run.
  bool play_loaded();
  /// Stops what runs, as on the pendant.
  void load_program(const std::string& file);
  /// False when there is nothing to pause or resume.
  bool pause_program();
  bool resume_program();

  void power_on();
  void power_off();
  void release_brakes();
  /// False while it is too early (5 s) or something else is wrong. What the arm touches then stops it again
  /// only when it presses harder or is not left within 0.2 rad.
  bool unlock_protective_stop();
  /// As the script ports take it: carried out as soon as it may be. UR's client library sends it at once
  /// after a stop and waits for the stop to end.
  void unlock_when_allowed() { unlock_asked_ = true; }
  /// The arm brakes along its path and the program is paused: it goes on where it was once the stop has been
  /// unlocked and the program played.
  void protective_stop(int code, const std::string& reason);
  void emergency_stop();
  void restart_safety();
  void close_popup();

  /// An RTDE client wrote this input: feeds watchdogs.
  void input_written(const std::string& name);
  void emit(ControllerEvent event) { events_.push_back(std::move(event)); }
  [[nodiscard]] std::vector<ControllerEvent> take_events();

  [[nodiscard]] bool program_running() const {
    return runtime_ == RuntimeState::kPlaying || runtime_ == RuntimeState::kResuming;
  }
  /// Paused, or being braked for a pause.
  [[nodiscard]] bool program_held() const {
    return runtime_ == RuntimeState::kPausing || runtime_ == RuntimeState::kPaused;
  }
  [[nodiscard]] RuntimeState runtime() const { return runtime_; }
  [[nodiscard]] const std::string& program_name() const { return program_name_; }
  [[nodiscard]] int program_line() const { return program_ ? program_->line() : 0; }
  [[nodiscard]] bool can_move() const;
  [[nodiscard]] bool has_function(const std::string& name) const;
  [[nodiscard]] std::uint32_t robot_status_bits() const;
  [[nodiscard]] std::uint32_t safety_status_bits() const;

  /// For the motion functions: only one thread of one program may move the arm at a time.
  void claim_motion(const urscript::Machine& machine, int thread);
  [[nodiscard]] bool is_secondary(const urscript::Machine& machine) const;
  void set_payload(double mass, const Eigen::Vector3d& p_F_cog);
  /// zero_ftsensor.
  void zero_wrench();

  [[nodiscard]] const UrServerOptions& options() const { return options_; }
  [[nodiscard]] const UrVersion& version() const { return version_; }
  [[nodiscard]] const PlantState& plant() const { return measured_; }
  /// Wrench on the tool as RTDE's actual_TCP_force: base axes, weight of the payload subtracted. About the
  /// tool centre point on a CB3; on an e-Series about the flange, by its sensor, and zero since the payload
  /// was set, a program started or zero_ftsensor was called.
  [[nodiscard]] Six wrench() const { return has_sensor_ ? sensor_wrench() : tool_wrench(); }
  /// RTDE's ft_raw_wrench: as the sensor in the flange measures it, axes of F.
  [[nodiscard]] Six raw_wrench() const { return sensed_ + sensor_offset(); }
  [[nodiscard]] const std::deque<Joints>& history() const { return history_; }
  /// Force on the tool without the payload's weight that many control steps ago, base axes, without the
  /// sensor's errors; of the oldest step that is known.
  [[nodiscard]] Eigen::Vector3d force_before(std::size_t steps) const;
  /// Share of its path's speed that the arm has: slider times limiter.
  [[nodiscard]] double scaling() const { return slider_ * limiter_; }
  /// RTDE's speed_scaling, "of the trajectory limiter": what holds the arm besides the slider. 0 in a pause.
  [[nodiscard]] double limiter() const { return limiter_; }

  ControllerFaults faults;
  Motion motion;
  Registers registers;
  ControllerIo io;
  Watchdog watchdog;
  RobotMode robot_mode = RobotMode::kRunning;
  SafetyMode safety_mode = SafetyMode::kNormal;
  double speed_slider = 1.0;
  std::string user_role = "NONE";         ///< of the Dashboard; NONE: everything is allowed
  std::string operational_mode = "NONE";  ///< of the Dashboard; NONE: nobody controls it from there
  std::string loaded_program;             ///< of the Dashboard; empty: none
  double payload = 0.0;
  Eigen::Vector3d payload_cog = Eigen::Vector3d::Zero();
  Six payload_inertia = Six::Zero();               ///< xx, yy, zz, xy, xz, yz; reported, without effect
  Six external_wrench = Six::Zero();               ///< RTDE's external_force_torque
  std::map<std::string, ScriptSocket> sockets;     ///< by the name that the script gave
  std::map<std::string, RtdeValue> masked_inputs;  ///< RTDE inputs that come with a mask, as last written
  bool popup_open = false;
  bool guided_by_hand = false;  ///< teach mode or freedrive: by name only, nobody is there who pushes
  int flight_reports = 0;       ///< that the Dashboard was asked for

 private:
  void trigger_faults();
  void set_safety_mode(SafetyMode mode);
  void change_power();
  void watch();
  void run_programs();
  void ask_for_program();
  void take_program_asked_for();
  void end_program(const char* key);
  void report(const urscript::CompileError& error, const urscript::Program* secondary);
  void scale_speed();
  void move();
  void measure();
  void feel(const Pose& T_B_F, const Eigen::Vector3d& force_B, const Eigen::Vector3d& torque_B);
  void zero_sensor();
  [[nodiscard]] static Six sensor_offset();
  [[nodiscard]] Six payload_weight() const;
  [[nodiscard]] Six tool_wrench() const { return estimate_ - estimate_zero_; }
  [[nodiscard]] Six sensor_wrench() const;
  [[nodiscard]] Six wrench_at_tool() const;
  void watch_for_collisions();

  /// Something that the arm touched when a protective stop was acknowledged.
  struct Touched {
    Joints q;
    double force = 0.0;  ///< force [N] on the flange
    double last = 0.0;   ///< uptime of the last touch [s]
  };

  UrServerOptions options_;
  UrVersion version_;
  Plant* plant_;
  double period_;
  double start_;
  std::uint64_t steps_ = 0;
  PlantState measured_;
  bool has_sensor_;                                           // e-Series
  Six estimate_ = Six::Zero(), estimate_zero_ = Six::Zero();  // at the tool centre point, axes of B
  Six sensed_ = Six::Zero(), sensor_zero_ = Six::Zero();      // at the flange, axes of F
  std::deque<Joints> history_;
  std::deque<Eigen::Vector3d> estimates_;  // of the force, as long
  std::unique_ptr<urscript::Machine> program_;
  std::vector<std::unique_ptr<urscript::Machine>> secondaries_;
  int effort_ = 0;  // that programs may still take; below 0: taken beforehand from the next step
  std::string program_name_;
  bool asked_ = false;  // External Control waits for its program
  RuntimeState runtime_ = RuntimeState::kStopped;
  double program_started_ = 0.0;
  double slider_ = 1.0, limiter_ = 1.0;  // as they take effect
  double stopped_at_ = -1.0;             // protective stop
  bool unlock_asked_ = false;
  std::optional<Touched> touched_;
  double power_change_at_ = -1.0;  // when robot_mode goes on to
  RobotMode power_goal_ = RobotMode::kRunning;
  int motion_owner_ = 0;
  std::vector<ControllerEvent> events_;
};

/// The functions that programs may call.
[[nodiscard]] const urscript::Library& robot_library();

/// "3.15.8.106339". Throws InvalidArgument.
[[nodiscard]] UrVersion parse_ur_version(const std::string& text);

}  // namespace stonestack::emulators
