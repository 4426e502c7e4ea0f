#include "hardware/ur/dashboard_client.hpp"
#include "protocol/dashboard_text.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr std::size_t kLongestLine = 1024;
constexpr const char* kGreeting = "Connected: Universal Robots Dashboard Server";
constexpr UrVersion kNever{};
constexpr UrVersion kSafetyStatus5{5, 4, 0, 0};
constexpr UrVersion kRemote5{5, 6, 0, 0};
constexpr UrVersion kModel3{3, 12, 0, 0}, kModel5{5, 6, 0, 0};

}  // namespace

DashboardClient::DashboardClient(const Endpoint& controller, const DashboardOptions& options)
    : controller_(controller), options_(options) {}

void DashboardClient::fail(const std::string& problem, const std::string& next_step) {
  stream_.reset();
  throw DeviceError("UR Dashboard at " + to_text(controller_), problem, next_step);
}

std::string DashboardClient::read_line(double seconds) {
  LineResult read;
  try {
    read = stream_->read_line(kLongestLine, Deadline::in(seconds).or_interrupt());
  } catch (const DeviceError& error) {
    fail(error.what(), "is this the Dashboard's port (29999)?");
  }
  if (read.status == IoStatus::kTimeOut)
    fail(concat("no answer within ", seconds, " s"), "look whether the controller is up");
  if (read.status == IoStatus::kClosed)
    fail("closed the connection", "look whether the Dashboard server is enabled in the security settings");
  if (!is_dashboard_text(read.line)) fail("answers with bytes that are no text", "is this port 29999?");
  return read.line;
}

void DashboardClient::connect() {
  if (stream_) return;
  try {
    stream_ = TcpStream::connect(controller_, Deadline::in(options_.connect_timeout).or_interrupt());
  } catch (const DeviceError& error) {
    fail(error.what(),
         "enable the Dashboard server in the security settings (PolyScope X, version 10, has none)");
  }
  const std::string greeting = read_line(options_.greeting_timeout);
  if (greeting.rfind(kGreeting, 0) != 0) fail("greets with '" + greeting + "'", "is this port 29999?");
}

std::string DashboardClient::ask(const std::string& command) {
  require(is_dashboard_text(command), "a Dashboard command is one printable line");
  connect();
  const IoResult sent = stream_->write_all(command + "\n", Deadline::in(options_.reply_timeout));
  if (!sent) fail("takes no command: " + std::string(io_status_name(sent.status)), "try again");
  return read_line(options_.reply_timeout);
}

std::string DashboardClient::ask_for(const std::string& command, const std::string& label) {
  const std::string reply = ask(command);
  const auto value = dashboard_value(reply, label);
  if (!value) fail("answers '" + command + "' with '" + reply + "'", "look at the pendant");
  return *value;
}

void DashboardClient::order(const std::string& command, const std::string& expected) {
  const std::string reply = ask(command);
  if (reply.rfind(expected, 0) != 0)
    fail("answers '" + command + "' with '" + reply + "'", "look at the pendant");
}

UrVersion DashboardClient::version() {
  if (version_) return *version_;
  const std::string reply = ask("PolyscopeVersion");
  version_ = parse_polyscope_version(reply);
  if (!version_) fail("answers 'PolyscopeVersion' with '" + reply + "'", "is this port 29999?");
  return *version_;
}

std::string DashboardClient::robot_mode() {
  return ask_for("robotmode", "Robotmode:");
}

std::string DashboardClient::safety() {
  if (version().has(kNever, kSafetyStatus5)) return ask_for("safetystatus", "Safetystatus:");
  return ask_for("safetymode", "Safetymode:");
}

std::optional<bool> DashboardClient::is_in_remote_control() {
  if (!version().has(kNever, kRemote5)) return std::nullopt;
  const std::string reply = ask("is in remote control");
  const auto truth = dashboard_truth(reply);
  if (!truth) fail("answers 'is in remote control' with '" + reply + "'", "look at the pendant");
  return truth;
}

std::optional<std::string> DashboardClient::robot_model() {
  if (!version().has(kModel3, kModel5)) return std::nullopt;
  return ask("get robot model");
}

std::optional<std::string> DashboardClient::serial_number() {
  if (!version().has(kModel3, kModel5)) return std::nullopt;
  return ask("get serial number");
}

void DashboardClient::require_serial(const std::string& wanted) {
  if (wanted.empty()) return;
  const std::string serial = serial_number().value_or("");
  if (serial == wanted) return;
  fail(concat(serial.empty() ? std::string("the controller does not say the arm's serial number")
                             : "the arm has the serial number " + serial,
              ", and the cell's arm.serial is ", wanted),
       "check arm.address, or run `stonestack setup` again for this arm");
}

bool DashboardClient::is_program_running() {
  const std::string value = ask_for("running", "Program running:");
  const auto truth = dashboard_truth(value);
  if (!truth) fail("answers 'running' with '" + value + "'", "look at the pendant");
  return *truth;
}

void DashboardClient::power_on() {
  order("power on", "Powering on");
}

void DashboardClient::power_off() {
  order("power off", "Powering off");
}

void DashboardClient::release_brakes() {
  order("brake release", "Brake releasing");
}

void DashboardClient::stop_program() {
  order("stop", "Stopped");
}

void DashboardClient::close_popup() {
  order("close popup", "closing popup");
}

void DashboardClient::close_safety_popup() {
  order("close safety popup", "closing safety popup");
}

void DashboardClient::show_popup(const std::string& text) {
  order("popup " + text, "showing popup");
}

void DashboardClient::unlock_protective_stop() {
  order("unlock protective stop", "Protective stop releasing");
}

}  // namespace stonestack::hardware
