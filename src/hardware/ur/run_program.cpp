#include "hardware/ur/run_program.hpp"

#include <utility>

#include "hardware/constants.hpp"
#include "hardware/guard_readings.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

using Status = MotionResult::Status;

constexpr double kStragglers = 0.1;   // s for errors that follow the end of a program
constexpr double kComesToRest = 0.5;  // s after which a paused arm stands

/// Keeps the controller's messages about the program.
class Hearing {
 public:
  Hearing(UrLink& link, const std::string& script) : link_(link), script_(script) {
    static_cast<void>(link.primary.take_messages());  // about older programs
  }
  void listen() {
    for (const PrimaryMessage& message : link_.primary.take_messages()) {
      read_only_ = read_only_ || is_read_only_error(message);
      if (message.kind == PrimaryMessage::Kind::kRuntimeException)
        note(concat("line ", message.line, ": ", message.text, ": '", script_line(script_, message.line),
                    "'"));
      else if (message.kind == PrimaryMessage::Kind::kError && !is_read_only_error(message))
        note(concat("C", message.code, "A", message.argument, " ", message.text));
    }
  }
  /// After a short wait for what comes late.
  [[nodiscard]] std::string last_words() {
    std::this_thread::sleep_for(std::chrono::duration<double>(kStragglers));
    listen();
    return reports_;
  }
  [[nodiscard]] const std::string& reports() const { return reports_; }
  [[nodiscard]] bool died() const { return !reports_.empty(); }
  /// True once after each C210.
  [[nodiscard]] bool take_read_only() { return std::exchange(read_only_, false); }

 private:
  void note(const std::string& text) { reports_ += (reports_.empty() ? "" : "; ") + text; }
  UrLink& link_;
  const std::string& script_;
  std::string reports_;
  bool read_only_ = false;
};

/// One program from its sending to its end.
class Run {
 public:
  Run(UrLink& link, const ProgramOrder& order)
      : link_(link), order_(order), hearing_(link, order.script), sessions_(link.rtde.counts().sessions) {}

  /// Sends a stop unless the program came to its own end: what nobody waits for any more must not go on.
  MotionResult carry_through() {
    MotionResult ended;
    try {
      ended = wait_for_end();
    } catch (...) {
      end_program();
      throw;
    }
    if (ended.status == Status::kDone || ended.status == Status::kContact ||
        ended.status == Status::kNoContact)
      return ended;
    end_program();
    if (overdue_) return explain_overdue();
    ended.q = last_.q;
    return ended;
  }

 private:
  MotionResult wait_for_end() {
    if (auto failed = start()) return *failed;
    for (;;) {
      const UrStatus now = turn();
      if (auto ended = check(now)) return *ended;
    }
  }

  [[nodiscard]] MotionResult result(Status status, const std::string& reason) const {
    return {status, last_.q, last_.force, reason, readings_.mean_of_second_half()};
  }

  void end_program() noexcept {
    if (!sent_) return;
    try {
      confirm_stop(send_stop(link_));
    } catch (const std::exception& error) {
      link_.starve(std::string("whether a stop was obeyed is not known: ") + error.what());
    }
    link_.program_in_transit = false;
  }

  /// A program that a stop does not reach goes on, or moves when somebody plays it: without the heartbeat,
  /// the controller's watchdog ends it. `stop`: run id; 0: it could not be sent.
  void confirm_stop(int stop) {
    Deadline deadline = Deadline::in(link_.options.stop_timeout);
    bool resent = false;
    while (stop != 0) {
      last_ = link_.next_status();
      came_late_ = came_late_ || last_.run == order_.run;
      const bool is_there = last_.program_running || last_.is_held();
      const bool is_coming = link_.program_in_transit && last_.run != stop && find_safety_stop(last_).empty();
      if (!is_there && !is_coming) return;
      hearing_.listen();
      if (!resent && hearing_.take_read_only()) {
        resent = true;
        link_.primary.reconnect();
        stop = send_stop(link_);
        deadline = Deadline::in(link_.options.stop_timeout);
        continue;
      }
      if (!deadline.over()) continue;
      if (is_there)
        link_.starve(concat(last_.is_held() ? "a paused program" : "a program", " did not obey a stop"));
      return;
    }
  }

  /// False: a stop was asked for.
  bool send() {
    throw_if_interrupted();
    link_.program_in_transit = true;                 // before it is: a stop that waits its turn must know
    const bool before = std::exchange(sent_, true);  // a part of it, if this throws
    if (link_.primary.send_unless(order_.script, order_.stop_asked)) return true;
    link_.program_in_transit = false;
    sent_ = before;
    return false;
  }

  UrStatus turn() {
    throw_if_interrupted();
    last_ = link_.next_status();
    if (order_.each_turn) order_.each_turn(last_);
    hearing_.listen();
    return last_;
  }

  /// Empty once the program has written its run id.
  std::optional<MotionResult> start() {
    last_ = link_.status();
    q_before_ = last_.q;
    if (!send()) return stopped_by_command();
    Deadline deadline = Deadline::in(link_.options.start_timeout);
    bool resent = false;
    while (!deadline.over()) {
      const UrStatus now = turn();
      if (now.run == order_.run) {
        link_.program_in_transit = false;
        return std::nullopt;
      }
      if (auto stopped = find_stop(now)) return stopped;
      if (hearing_.died())
        return result(Status::kRefused, "the program did not start: " + hearing_.last_words());
      if (!hearing_.take_read_only()) continue;
      link_.program_in_transit = false;
      if (resent) break;  // C210 twice
      resent = true;
      link_.primary.reconnect();
      if (auto other = link_.other_safety_configuration(); !other.empty())
        return result(Status::kRefused, other);
      if (!send()) return stopped_by_command();
      deadline = Deadline::in(link_.options.start_timeout);
    }
    overdue_ = true;
    return result(Status::kRefused, {});
  }

  /// After the stop: asking the Dashboard takes seconds, in which a program that starts late would move.
  [[nodiscard]] MotionResult explain_overdue() const {
    if (came_late_ || (last_.q - q_before_).cwiseAbs().maxCoeff() > kStartTolerance)
      return result(Status::kStopped, "the program started late and was stopped");
    return result(Status::kRefused, concat("the program did not start within ", link_.options.start_timeout,
                                           " s; ", link_.explain_silence()));
  }

  [[nodiscard]] MotionResult stopped_by_command() const {
    return result(Status::kStopped, "stopped by command");
  }

  /// Safety stop, a stop that was asked for, a link that was lost in between.
  std::optional<MotionResult> find_stop(const UrStatus& now) {
    if (const auto safety = find_safety_stop(now); !safety.empty()) {
      link_.disarm(safety);
      return result(Status::kStopped, safety);
    }
    if (order_.stop_asked != nullptr && *order_.stop_asked) return stopped_by_command();
    if (link_.rtde.counts().sessions == sessions_) return std::nullopt;
    return result(Status::kLost,
                  "the RTDE link was lost in transit; the controller's watchdog has stopped it");
  }

  std::optional<MotionResult> check(const UrStatus& now) {
    if (auto stopped = find_stop(now)) return stopped;
    if (now.run != order_.run)
      return result(Status::kStopped, "another program has taken the controller; end the other client");
    if (!now.program_running && !now.is_held()) return now.end != 0 ? finish(now) : look_for_death();
    ended_for_.reset();
    if (now.program_running) readings_.add(now.force);
    if (auto moved = look_for_moved_arm(now)) return moved;
    return keep_time(now);
  }

  /// In a pause nothing but a person moves the arm, and the program would jump back to where it was.
  std::optional<MotionResult> look_for_moved_arm(const UrStatus& now) {
    if (now.runtime_state != UrStatus::kPaused) {
      held_.reset();
      return std::nullopt;
    }
    if (!held_) held_ = Held{now.device_time, now.q};
    if (now.device_time - held_->since < kComesToRest) held_->q = now.q;
    const double moved = (now.q - held_->q).cwiseAbs().maxCoeff();
    if (moved <= kStartTolerance) return std::nullopt;
    return result(Status::kStopped, concat("the arm was moved by ", moved,
                                           " rad while the program was paused; it is not resumed"));
  }

  std::optional<MotionResult> finish(const UrStatus& now) {
    switch (static_cast<ScriptEnd>(now.end)) {
      case ScriptEnd::kDone:
        return result(Status::kDone, {});
      case ScriptEnd::kContact:
        return result(Status::kContact, concat("contact at ", now.force, " N"));
      case ScriptEnd::kNoContact:
        return result(Status::kNoContact, "no contact up to the end of the motion");
      case ScriptEnd::kStaleForce:
        return result(Status::kStopped,
                      "the force readings stopped coming through; the arm stopped by itself");
      case ScriptEnd::kFellBehind:
        return result(
            Status::kStopped,
            "the arm was too far from its path (held back, or moved in a pause); it stopped by itself "
            "instead of catching up");
      case ScriptEnd::kRunning:
        break;
    }
    return result(Status::kStopped, concat("unknown end state ", now.end));
  }

  /// The program is over without a report.
  std::optional<MotionResult> look_for_death() {
    if (!ended_for_) ended_for_.emplace();
    if (!hearing_.died() && ended_for_->seconds() < link_.options.end_grace) return std::nullopt;
    const std::string words = hearing_.last_words();
    const UrStatus late = turn();
    if (late.end != 0 && late.run == order_.run && words.empty()) return finish(late);
    if (auto stopped = find_stop(late)) return stopped;
    return result(Status::kStopped,
                  words.empty()
                      ? "the program was killed: on the pendant, by another client, or by the heartbeat "
                        "watchdog"
                      : "the program died at " + words);
  }

  /// The limit runs at the speed of the arm; a pause is the user's.
  std::optional<MotionResult> keep_time(const UrStatus& now) {
    const double dt = std::max(0.0, now.device_time - before_.value_or(now.device_time));
    before_ = now.device_time;
    if (now.is_paused()) {
      paused_ += dt;
      if (paused_ < link_.options.pause_limit) return std::nullopt;
      return result(Status::kStopped,
                    concat("paused by the user (program paused or speed slider at 0) for ", paused_, " s"));
    }
    used_ += dt * std::min(1.0, now.speed);
    const double allowed = kTimeFactor * order_.duration + link_.options.time_slack;
    if (used_ < allowed) return std::nullopt;
    return result(Status::kStopped, concat("not done after ", used_, " s, expected ", order_.duration,
                                           " s; at knot ", now.progress));
  }

  UrLink& link_;
  const ProgramOrder& order_;
  Hearing hearing_;
  const int sessions_;
  UrStatus last_;
  Joints q_before_ = Joints::Zero();  // the program
  bool sent_ = false, overdue_ = false, came_late_ = false;
  GuardReadings readings_;
  std::optional<Stopwatch> ended_for_;
  std::optional<double> before_;
  struct Held {
    double since = 0.0;  // s, the controller's clock
    Joints q;            // where the arm came to rest
  };
  std::optional<Held> held_;  // in a pause
  double used_ = 0.0, paused_ = 0.0;
};

}  // namespace

int send_stop(UrLink& link) noexcept {
  try {
    ScriptContext context;
    context.version = link.version;
    context.run = link.next_run();
    context.options = link.options.script;
    link.primary.send(write_stop(context));
    return context.run;
  } catch (const std::exception& error) {
    link.starve(std::string("could not send a stop: ") + error.what());
    log_warning(std::string("could not send a stop, the controller's watchdog must do it: ") + error.what());
    return 0;
  }
}

MotionResult run_program(UrLink& link, const ProgramOrder& order) {
  return Run(link, order).carry_through();
}

}  // namespace stonestack::hardware
