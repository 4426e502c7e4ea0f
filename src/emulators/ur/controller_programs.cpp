// The part of the controller that starts, runs and ends programs.
#include <algorithm>
#include <cctype>

#include "emulators/ur/controller.hpp"
#include "stonestack/core/error.hpp"
#include "urscript/script_collector.hpp"

namespace stonestack::emulators {
namespace {

using urscript::Machine;
using Kind = ControllerEvent::Kind;

constexpr std::size_t kSecondaries = 8;
constexpr int kFieldbusLost = 206;  // C-code

/// Functions that came with some version: PolyScope 3, PolyScope 5.
struct Gate {
  const char* name;
  UrVersion cb3, e_series;
};
constexpr Gate kGates[] = {
    {"force_mode_set_damping", {3, 5, 0, 0}, {5, 0, 0, 0}},
    {"get_inverse_kin_has_solution", {3, 12, 0, 0}, {5, 6, 0, 0}},
    {"force_mode_set_gain_scaling", {0, 0, 0, 0}, {5, 0, 0, 0}},
    {"protective_stop", {3, 8, 0, 0}, {5, 0, 0, 0}},
    {"rtde_set_watchdog", {3, 3, 0, 0}, {5, 0, 0, 0}},
    {"get_steptime", {3, 10, 0, 0}, {5, 4, 0, 0}},
    {"tool_contact", {3, 12, 0, 0}, {5, 4, 0, 0}},
    {"get_actual_joint_positions_history", {3, 12, 0, 0}, {5, 4, 0, 0}},
    {"get_target_waypoint", {3, 8, 0, 0}, {5, 3, 0, 0}},
    {"ft_rtde_input_enable", {3, 14, 1, 0}, {5, 9, 1, 0}},
    {"set_target_payload", {3, 15, 0, 0}, {5, 10, 0, 0}},
    {"get_freedrive_status", {0, 0, 0, 0}, {5, 10, 0, 0}},
    {"set_tool_communication", {0, 0, 0, 0}, {5, 0, 0, 0}},
    {"optimovej", {0, 0, 0, 0}, {5, 21, 0, 0}},
    {"optimovel", {0, 0, 0, 0}, {5, 21, 0, 0}},
    {"direct_torque", {0, 0, 0, 0}, {5, 23, 0, 0}},
    {"struct", {0, 0, 0, 0}, {5, 10, 0, 0}},  // UR's client library
    {"get_target_payload", {3, 11, 0, 0}, {5, 0, 0, 0}},
    {"get_target_payload_cog", {3, 11, 0, 0}, {5, 0, 0, 0}},
    {"get_target_payload_inertia", {3, 15, 0, 0}, {5, 10, 0, 0}},
};

ControllerEvent make_event(Kind kind, std::string title, std::string text) {
  ControllerEvent event;
  event.kind = kind;
  event.title = std::move(title);
  event.text = std::move(text);
  return event;
}

}  // namespace

bool UrController::has_function(const std::string& name) const {
  if (robot_library().index(name) < 0) return false;
  for (const auto& gate : kGates)
    if (name == gate.name) return version_.has(gate.cb3, gate.e_series);
  return true;
}

void UrController::report(const urscript::CompileError& error, const urscript::Program* secondary) {
  auto event = make_event(Kind::kRuntimeException, "",
                          (secondary ? "SECONDARY_PROGRAM_EXCEPTION_XXX" : "") + error.text);
  event.line = error.line;
  event.column = error.column;
  emit(event);
}

void UrController::run_script(const std::string& source) {
  if (!faults.scripts_never_start) run(compile(source));
}

CompiledScript UrController::compile(const std::string& source) const {
  try {
    if (source.size() > kLongestScript)
      throw urscript::CompileError{
          1, 1, concat("script too long: more than ", kLongestScript, " characters; make it shorter")};
    return {urscript::compile(source,
                              [this](const std::string& name) {
                                return has_function(name) ? robot_library().index(name) : -1;
                              }),
            {}};
  } catch (const urscript::CompileError& error) {
    return {std::nullopt, error};
  } catch (const urscript::ScriptError& error) {
    return {std::nullopt, {1, 1, error.text}};
  } catch (const std::exception& error) {
    return {std::nullopt, {1, 1, concat("Internal error: ", error.what())}};
  }
}

void UrController::run(CompiledScript script) {
  if (faults.scripts_never_start) return;
  if (!script.program) return report(script.error, nullptr);
  urscript::Program& program = *script.program;
  if (program.secondary) {
    if (secondaries_.size() >= kSecondaries)
      return report({1, 1, concat("more than ", kSecondaries, " secondary programs at once")}, &program);
    secondaries_.push_back(std::make_unique<Machine>(std::move(program), robot_library(), *this));
    return;
  }
  if (program_) end_program("PROGRAM_XXX_STOPPED");
  program_name_ = program.name.empty() ? "unnamed" : program.name;
  emit(make_event(Kind::kKey, "PROGRAM_XXX_STARTED", program_name_));
  if (!can_move()) {  // a robot that may not move ends every program at once
    emit(make_event(Kind::kKey, "PROGRAM_XXX_STOPPED", program_name_));
    return;
  }
  program_ = std::make_unique<Machine>(std::move(program), robot_library(), *this);
  zero_sensor();  // UR in Universal_Robots_ROS_Driver #512: with every start of a program
  program_started_ = uptime();
  motion_owner_ = 0;
  runtime_ = RuntimeState::kPlaying;
  if (faults.fieldbus_stops_programs)
    protective_stop(kFieldbusLost, "Fieldbus connection lost: fault switch");
}

void UrController::stop_program() {
  if (program_) end_program("PROGRAM_XXX_STOPPED");
}

void UrController::end_program(const char* title) {
  program_.reset();
  asked_ = false;
  runtime_ = RuntimeState::kStopped;
  watchdog = {};
  sockets.clear();
  guided_by_hand = false;
  ForceMode off;
  motion.set_force_mode(off);
  if (motion.moving())
    motion.stop_joints(10.0);
  else
    motion.freeze();  // in a pause it has a motion left
  emit(make_event(Kind::kKey, title, program_name_));
}

void UrController::load_program(const std::string& file) {
  stop_program();
  loaded_program = program_name_ = file;
}

bool UrController::play_loaded() {
  if (loaded_program.empty() || program_running() || !can_move()) return false;
  if (options_.external_control > 0 && loaded_program == kExternalControl) {
    ask_for_program();
    return program_running();
  }
  std::string name = loaded_program.substr(0, loaded_program.rfind('.'));
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  run_script("def program_" + name + "():\n  while True:\n    sync()\n  end\nend\n");
  if (program_running()) program_name_ = loaded_program;
  return program_running();
}

bool UrController::pause_program() {
  if (!program_running()) return false;
  runtime_ = RuntimeState::kPausing;
  return true;
}

bool UrController::resume_program() {
  if (!program_held() || !can_move()) return false;
  runtime_ = RuntimeState::kResuming;
  watchdog.fed = uptime();
  return true;
}

void UrController::close_popup() {
  popup_open = false;
}

bool UrController::is_secondary(const Machine& machine) const {
  return &machine != program_.get();
}

void UrController::claim_motion(const Machine& machine, int thread) {
  if (is_secondary(machine)) throw urscript::ScriptError{"A secondary program may not move the robot"};
  if (motion_owner_ != thread && motion_owner_ != 0 && machine.is_alive(motion_owner_) && !motion.done())
    throw urscript::ScriptError{"Another thread is already controlling the robot"};
  motion_owner_ = thread;
}

void UrController::run_programs() {
  effort_ = std::min(effort_, 0) + urscript::kStepQuota;
  const auto step = [this](Machine& machine, std::size_t others) {
    const auto state = machine.step(effort_ / static_cast<int>(1 + others));
    effort_ -= machine.spent();
    return state;
  };
  for (std::size_t i = 0; i < secondaries_.size() && effort_ > 0;) {
    auto& machine = *secondaries_[i];
    if (step(machine, secondaries_.size() - i) == Machine::State::kRunning) {
      ++i;
      continue;
    }
    if (machine.state() == Machine::State::kFailed) report(machine.error(), &machine.program());
    secondaries_.erase(secondaries_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (asked_) take_program_asked_for();
  if (!program_ || !program_running() || effort_ <= 0) return;
  const auto state = step(*program_, 0);
  if (state == Machine::State::kRunning) return;
  if (state == Machine::State::kFailed) report(program_->error(), nullptr);
  end_program("PROGRAM_XXX_STOPPED");
}

}  // namespace stonestack::emulators
