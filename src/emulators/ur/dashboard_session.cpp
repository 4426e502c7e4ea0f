#include "emulators/ur/dashboard_session.hpp"

#include <algorithm>
#include <cctype>

#include "protocol/rtde_wire.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

const char* robot_mode_name(RobotMode mode) {
  switch (mode) {
    case RobotMode::kPowerOff:
      return "POWER_OFF";
    case RobotMode::kPowerOn:
      return "POWER_ON";
    case RobotMode::kIdle:
      return "IDLE";
    case RobotMode::kBackdrive:
      return "BACKDRIVE";
    case RobotMode::kRunning:
      return "RUNNING";
  }
  return "NO_CONTROLLER";
}

const char* safety_mode_name(SafetyMode mode) {
  switch (mode) {
    case SafetyMode::kNormal:
      return "NORMAL";
    case SafetyMode::kProtectiveStop:
      return "PROTECTIVE_STOP";
    case SafetyMode::kRobotEmergencyStop:
      return "ROBOT_EMERGENCY_STOP";
    case SafetyMode::kFault:
      return "FAULT";
  }
  return "UNDEFINED";
}

std::string program_state(const UrController& c) {
  const char* state = c.program_running() ? "PLAYING" : c.program_held() ? "PAUSED" : "STOPPED";
  return concat(state, ' ', c.program_name().empty() ? "<unnamed>" : c.program_name());
}

std::string unlock(UrController& c) {
  if (c.safety_mode != SafetyMode::kProtectiveStop) return "Protective stop releasing";
  return c.unlock_protective_stop() ? "Protective stop releasing"
                                    : "Cannot unlock protective stop until 5s after occurrence. Always "
                                      "inspect cause of protective stop before unlocking";
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

// Who works at the pendant and how: CB3 has roles, e-Series operational modes. Empty: none of these commands.
std::string administer(UrController& c, const std::string& command) {
  static const std::string kRole = "setUserRole", kMode = "set operational mode ";
  const bool has_roles = c.version().is_cb3() && c.version().has({3, 1, 0, 0}, {0, 0, 0, 0});
  if (has_roles && command.rfind(kRole, 0) == 0) {
    const std::string role = command.size() > kRole.size() ? command.substr(kRole.size() + 1) : "none";
    for (const char* known : {"PROGRAMMER", "OPERATOR", "NONE", "LOCKED", "RESTRICTED"}) {
      if (upper(role) != known) continue;
      c.user_role = known;
      return "Setting user role: " + role;
    }
    return "Failed setting user role: " + role;
  }
  if (c.version().is_cb3()) return {};
  if (command.rfind(kMode, 0) == 0) {
    const std::string mode = command.substr(kMode.size());
    if (upper(mode) != "MANUAL" && upper(mode) != "AUTOMATIC")
      return "Failed setting operational mode: " + mode;
    c.operational_mode = upper(mode);
    return "Operational mode " + mode + " is set";
  }
  if (command != "clear operational mode") return {};
  c.operational_mode = "NONE";
  return "No longer controlling the operational mode. Current operational mode: 'NONE'.";
}

// In whatever folder it is looked for: "/programs/x", "/ursim/programs/x".
std::string file_of(const std::string& path) {
  return path.substr(path.rfind('/') + 1);  // all of it when there is none
}

std::string load(UrController& c, const std::string& name) {
  auto known = split_names(c.options().programs);
  if (c.options().external_control > 0) known.emplace_back(kExternalControl);
  if (std::find(known.begin(), known.end(), file_of(name)) == known.end()) return "File not found: " + name;
  c.load_program(file_of(name));
  return "Loading program: " + name;
}

// Every controller comes with this one.
std::string load_installation(UrController& c, const std::string& name) {
  if (file_of(name) != "default.installation") return "File not found: " + name;
  c.stop_program();
  return "Loading installation: " + name;
}

// What a controller does on its own disk, of which nobody sees more than the answer.
std::string keep_record(UrController& c, const std::string& command) {
  static const std::string kLog = "addToLog", kReport = "generate flight report",
                           kSupport = "generate support file ";
  const bool has_reports = c.version().has({3, 13, 0, 0}, {5, 8, 0, 0});
  if (command == kLog || command.rfind(kLog + " ", 0) == 0)
    return command.find_first_not_of(' ', kLog.size()) == std::string::npos ? "No log message to add"
                                                                            : "Added log message";
  if (!has_reports) return {};
  if (command == "saveLog") return "Log saved to disk";
  if (command == kReport || command.rfind(kReport + " ", 0) == 0)
    return concat("Flight Report generated with id: ", ++c.flight_reports);
  if (command.rfind(kSupport, 0) != 0) return {};
  return concat("Completed successfully: ", command.substr(kSupport.size()), "/ur_", c.options().serial,
                "_support_file.zip");
}

// Commands that change something; empty when the command is none of them.
std::string act(UrController& c, const std::string& command) {
  if (command == "power on") {
    c.power_on();
    return "Powering on";
  }
  if (command == "power off") {
    c.power_off();
    return "Powering off";
  }
  if (command == "brake release") {
    c.release_brakes();
    return "Brake releasing";
  }
  if (command == "unlock protective stop") return unlock(c);
  if (command == "close safety popup") return "closing safety popup";
  if (command == "close popup") {
    c.close_popup();
    return "closing popup";
  }
  if (command == "play")
    return c.resume_program() || c.play_loaded() ? "Starting program" : "Failed to execute: play";
  if (command == "pause") return c.pause_program() ? "Pausing program" : "Failed to execute: pause";
  if (command == "stop") {  // "Stopped" even when nothing runs: UR's and ur_rtde's start sequences rely on it
    c.stop_program();
    return "Stopped";
  }
  if (command == "restart safety" && c.version().has({3, 7, 0, 0}, {5, 1, 0, 0})) {
    c.restart_safety();
    return "Restarting safety";
  }
  if (command == "shutdown") {
    c.power_off();
    return "Shutting down";
  }
  return {};
}

std::string ask(const UrController& c, const std::string& command) {
  const auto& version = c.version();
  if (command == "PolyscopeVersion") return "URSoftware " + to_string(version) + " (Jan 01 2024)";
  if (command == "robotmode") return concat("Robotmode: ", robot_mode_name(c.robot_mode));
  if (command == "safetymode") return concat("Safetymode: ", safety_mode_name(c.safety_mode));
  if (command == "safetystatus" && version.has({0, 0, 0, 0}, {5, 4, 0, 0}))
    return concat("Safetystatus: ", safety_mode_name(c.safety_mode));
  if (command == "running") return concat("Program running: ", c.program_running() ? "true" : "false");
  if (command == "programState") return program_state(c);
  if (command == "get loaded program")
    return c.loaded_program.empty() ? "No program loaded" : "Loaded program: /programs/" + c.loaded_program;
  if (command == "isProgramSaved")
    return "true " + (c.program_name().empty() ? "<unnamed>" : c.program_name());
  if (command == "is in remote control" && version.has({0, 0, 0, 0}, {5, 6, 0, 0}))
    return c.faults.local_mode ? "false" : "true";
  if (command == "get operational mode" && version.has({0, 0, 0, 0}, {5, 6, 0, 0})) return c.operational_mode;
  if (command == "getUserRole" && version.is_cb3() && version.has({3, 1, 0, 0}, {0, 0, 0, 0}))
    return c.user_role;
  if (command == "get robot model" && version.has({3, 12, 0, 0}, {5, 6, 0, 0})) return c.options().model;
  if (command == "get serial number" && version.has({3, 12, 0, 0}, {5, 6, 0, 0})) return c.options().serial;
  if (command == "version" && version.has({0, 0, 0, 0}, {5, 0, 0, 0})) return to_string(version);
  return {};
}

}  // namespace

DashboardAnswer answer_dashboard(UrController& controller, const std::string& command) {
  const auto starts = [&](const char* prefix) { return command.rfind(prefix, 0) == 0; };
  if (command == "quit") return {"Disconnected", true};
  // e-Series in local mode answers questions only.
  if (auto line = ask(controller, command); !line.empty()) return {line, false};
  if (controller.faults.local_mode && !controller.version().is_cb3())
    return {"Command is not allowed due to safety reasons", false};
  if (auto line = act(controller, command); !line.empty()) return {line, false};
  if (auto line = administer(controller, command); !line.empty()) return {line, false};
  if (auto line = keep_record(controller, command); !line.empty()) return {line, false};
  if (starts("popup ")) return {"showing popup", false};
  if (starts("load installation ")) return {load_installation(controller, command.substr(18)), false};
  if (starts("load ")) return {load(controller, command.substr(5)), false};
  return {"could not understand: '" + command + "'", false};
}

}  // namespace stonestack::emulators
