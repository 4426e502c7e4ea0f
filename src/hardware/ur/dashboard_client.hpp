#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/socket.hpp"
#include "protocol/ur_version.hpp"

namespace stonestack::hardware {

struct DashboardOptions {
  double connect_timeout = 2.0;    ///< [s]
  double greeting_timeout = 10.0;  ///< the server may be slow to greet [s]
  double reply_timeout = 1.0;      ///< [s]
};

/// Asks a UR controller's Dashboard server (port 29999; PolyScope 3 and 5). One line out, one line in. A late
/// or odd answer closes the connection, so that it cannot be taken for the next one; the next question
/// connects again. Every method throws DeviceError that quotes the answer. Not thread-safe.
class DashboardClient {
 public:
  explicit DashboardClient(const Endpoint& controller, const DashboardOptions& options = {});

  [[nodiscard]] UrVersion version();
  /// "RUNNING", "POWER_OFF", ...
  [[nodiscard]] std::string robot_mode();
  /// "NORMAL", "PROTECTIVE_STOP", ... From `safetystatus` where there is one (5.4), else `safetymode`.
  [[nodiscard]] std::string safety();
  /// Empty where there is no remote mode: CB3, and e-Series before 5.6.
  [[nodiscard]] std::optional<bool> is_in_remote_control();
  /// "UR10"; empty before 3.12 and 5.6.
  [[nodiscard]] std::optional<std::string> robot_model();
  /// Of the arm; empty before 3.12 and 5.6.
  [[nodiscard]] std::optional<std::string> serial_number();
  /// The address may have gone to another arm, with another calibration and safety configuration.
  /// @throws DeviceError unless `wanted` is the arm's serial number, or empty
  void require_serial(const std::string& wanted);
  [[nodiscard]] bool is_program_running();
  void power_on();
  void power_off();
  void release_brakes();
  void stop_program();
  void close_popup();
  void close_safety_popup();
  /// Shows a text on the pendant (one line).
  void show_popup(const std::string& text);
  /// Lifts a protective stop. Only for a person who has looked and asked for it: the vendor forbids automatic
  /// acknowledgement, and nothing but `rearm_arm` calls it. The controller refuses for 5 s after the stop.
  void unlock_protective_stop();

 private:
  [[nodiscard]] std::string ask(const std::string& command);
  void order(const std::string& command, const std::string& expected);
  std::string ask_for(const std::string& command, const std::string& label);
  void connect();
  [[nodiscard]] std::string read_line(double seconds);
  [[noreturn]] void fail(const std::string& problem, const std::string& next_step);

  Endpoint controller_;
  DashboardOptions options_;
  std::optional<TcpStream> stream_;
  std::optional<UrVersion> version_;
};

}  // namespace stonestack::hardware
