#include <chrono>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "hardware/cell_config.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "hardware/ur/ur_arm.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kUnlockTime = 7.0;  // s: the controller refuses for 5 s after the stop (URCL waits as long)
constexpr double kSafeTime = 5.0;    // s until an unlocked controller reports it. Design choice
constexpr double kPowerTime = 60.0;  // s that switching the arm on may take. Design choice
constexpr double kBrakeTime = 30.0;  // s, likewise for the brakes
constexpr double kTurn = 0.25;       // s between questions

const std::string kStop = "stop the program", kClosePopup = "close the safety popup",
                  kUnlock = "unlock the protective stop", kPower = "switch the arm on",
                  kBrakes = "release the brakes";

/// Meaning of a safety status for a person, and what to do about it by hand.
struct Meaning {
  std::string what, remedy;
};

const std::map<std::string, Meaning>& meanings() {
  static const std::map<std::string, Meaning> list = {
      {"ROBOT_EMERGENCY_STOP",
       {"the emergency stop button of the robot is pressed", "make the cell safe and release the button"}},
      {"SYSTEM_EMERGENCY_STOP",
       {"an emergency stop button of the system is pressed", "make the cell safe and release the button"}},
      {"SAFEGUARD_STOP", {"a safeguard is open", "leave the cell, close the safeguard and reset it"}},
      {"AUTOMATIC_MODE_SAFEGUARD_STOP",
       {"a safeguard of the automatic mode is open", "leave the cell, close the safeguard and reset it"}},
      {"SYSTEM_THREE_POSITION_ENABLING_STOP",
       {"the three-position switch is released", "hold it in its middle, or leave the manual mode"}},
      {"RECOVERY",
       {"a joint or the tool is outside the safety limits",
        "move the arm back by hand on the pendant (recovery mode)"}},
      {"VIOLATION",
       {"a safety limit was violated", "find out why from the pendant's log and restart the safety there"}},
      {"FAULT",
       {"the safety system reports a fault",
        "find out why from the pendant's log and restart the safety there"}}};
  return list;
}

bool is_safe(const ControllerState& state) {
  return state.safety == "NORMAL" || state.safety == "REDUCED";
}

[[noreturn]] void refuse(const std::string& arm, const std::string& what, const std::string& remedy) {
  throw Error(concat(arm, ": ", what, "; ", remedy, ", then run `stonestack rearm` again"),
              ExitCode::kSafetyStop);
}

ControllerState read(DashboardClient& dashboard) {
  return {dashboard.robot_mode(), dashboard.safety(), dashboard.is_program_running()};
}

/// Commands that the state needs. Throws where none helps.
std::vector<std::string> steps_for(const ControllerState& state, const std::string& arm) {
  std::vector<std::string> steps;
  if (!is_safe(state) && state.safety != "PROTECTIVE_STOP") {
    const auto known = meanings().find(state.safety);
    if (known != meanings().end()) refuse(arm, known->second.what, known->second.remedy);
    refuse(arm, "safety status " + state.safety, "look at the pendant");
  }
  const std::string& mode = state.robot_mode;
  const bool running = mode == "RUNNING", off = mode == "POWER_OFF";
  if (!running && !off && mode != "IDLE" && mode != "POWER_ON" && mode != "BOOTING")
    refuse(arm, "the robot is in mode " + mode, "bring it to a normal mode on the pendant");
  if (is_safe(state) && running) return steps;  // whatever runs is somebody's
  if (state.program_running) steps.push_back(kStop);
  if (!is_safe(state)) steps.insert(steps.end(), {kClosePopup, kUnlock});
  if (off) steps.push_back(kPower);
  if (!running) steps.push_back(kBrakes);
  return steps;
}

std::string meaning_of(const ControllerState& state) {
  if (!is_safe(state))
    return "the controller stopped the arm by itself: a collision, a position error or a limit. Its log on "
           "the pendant names the cause";
  if (state.robot_mode != "RUNNING") return "the arm has no power, or its brakes are on";
  return "the arm is ready";
}

void pause() {
  throw_if_interrupted();
  std::this_thread::sleep_for(std::chrono::duration<double>(kTurn));
}

/// Asks again while the controller refuses: it does so for some seconds after a stop.
void unlock(DashboardClient& dashboard) {
  for (const Stopwatch watch;;) {
    try {
      return dashboard.unlock_protective_stop();
    } catch (const DeviceError&) {
      if (watch.seconds() > kUnlockTime) throw;
    }
    pause();
  }
}

ControllerState wait_for(DashboardClient& dashboard, const std::string& arm, double seconds,
                         const std::string& what, const std::function<bool(const ControllerState&)>& done) {
  for (const Stopwatch watch;;) {
    const ControllerState state = read(dashboard);
    if (done(state)) return state;
    if (watch.seconds() > seconds)
      throw DeviceError(arm, concat(what, " for ", seconds, " s (", to_text(state), ")"),
                        "look at the arm and at the pendant");
    pause();
  }
}

void carry_out(const std::string& step, DashboardClient& dashboard, const std::string& arm) {
  if (step == kStop) return dashboard.stop_program();
  if (step == kClosePopup) return dashboard.close_safety_popup();
  if (step == kUnlock) {
    unlock(dashboard);
    static_cast<void>(wait_for(dashboard, arm, kSafeTime, "is still stopped", is_safe));
  } else if (step == kPower) {
    dashboard.power_on();
    static_cast<void>(wait_for(dashboard, arm, kPowerTime, "does not come on", [](const auto& state) {
      return state.robot_mode == "IDLE" || state.robot_mode == "RUNNING";
    }));
  } else {
    dashboard.release_brakes();
    static_cast<void>(wait_for(dashboard, arm, kBrakeTime, "does not release its brakes",
                               [](const auto& state) { return state.robot_mode == "RUNNING"; }));
  }
}

/// Motions are refused after a stop until somebody who has looked says so: that is what this is.
void check_motions(const CellConfig& config, const std::string& name) {
  const CellLayout layout = to_layout(config);
  UrArm arm(read_cell_robot(config), config.arm, layout.T_W_R, layout.T_F_T);
  arm.rearm();
  const ArmState state = arm.state();
  if (!state.can_move)
    throw DeviceError(name, "still refuses motions: " + state.stop_reason, "look at the pendant");
}

nlohmann::json state_json(const ControllerState& state) {
  return {
      {"robot_mode", state.robot_mode}, {"safety", state.safety}, {"program_running", state.program_running}};
}

}  // namespace

Rearming rearm_arm(const CellConfig& config, const ConfirmRearming& confirm) {
  require_arm_address(config);
  const std::string arm = "UR arm at " + config.arm.address;
  DashboardClient dashboard({config.arm.address, config.arm.dashboard_port});
  dashboard.require_serial(config.arm.serial);
  Rearming result;
  result.before = read(dashboard);
  const std::vector<std::string> steps = steps_for(result.before, arm);
  if (!steps.empty() && dashboard.is_in_remote_control() == false)
    refuse(arm, "the controller is in local control", "switch to Remote on the pendant, or do it there");
  if (!steps.empty() && !confirm(result.before, meaning_of(result.before), steps))
    throw Error(arm + ": nobody confirmed that the cell was looked at; nothing was done",
                ExitCode::kSafetyStop);
  for (const std::string& step : steps) {
    carry_out(step, dashboard, arm);
    result.steps.push_back(step);
  }
  check_motions(config, arm);
  result.after = read(dashboard);
  return result;
}

std::string to_text(const ControllerState& state) {
  return concat("robot ", state.robot_mode, ", safety ", state.safety, ", ",
                state.program_running ? "a program runs" : "no program runs");
}

std::string rearming_json(const Rearming& rearming) {
  return nlohmann::json{{"schema", "stonestack.rearm/1"},
                        {"before", state_json(rearming.before)},
                        {"steps", rearming.steps},
                        {"after", state_json(rearming.after)}}
             .dump(2) +
         "\n";
}

}  // namespace stonestack::hardware
