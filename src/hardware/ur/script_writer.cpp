#include "hardware/ur/script_writer.hpp"

#include <cmath>
#include <sstream>

#include "hardware/constants.hpp"
#include "hardware/ur/script_guard.hpp"
#include "hardware/ur/script_lines.hpp"
#include "hardware/ur/script_text.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr UrVersion kUpperRegisters3{3, 9, 0, 0}, kUpperRegisters5{5, 3, 0, 0};
constexpr double kChase =
    2.0;  // times the lag at which the path waits, which leaves the arm little more behind

/// The run id comes last: who sees it never sees the end, or the force, of an older run.
void begin(ScriptLines& out) {
  const ScriptContext& c = out.context();
  require(c.run > 0, "a run id must be positive, got ", c.run);
  require(!c.payload || *c.payload >= 0, "a payload cannot be ", c.payload.value_or(0), " kg");
  out.add(0, "def ", script_name(c.run), "():");
  if (out.reg(0) == 0) out.add(1, "# Before 3.9 (5.3): registers 0..23, shared with fieldbuses.");
  out.add(1, "write_output_integer_register(", out.reg(2), ", ", number(ScriptEnd::kRunning), ")");
  out.add(1, "write_output_integer_register(", out.reg(1), ", 0)");
  out.add(1, "write_output_float_register(", out.reg(6), ", 0.0)");
  out.add(1, "write_output_integer_register(", out.reg(0), ", ", c.run, ")");
}

void watch_heartbeat(ScriptLines& out) {
  out.add(1, "rtde_set_watchdog(\"input_int_register_", out.reg(0), "\", ",
          to_script(out.options().heartbeat_rate), ", \"stop\")");
}

void set_tool(ScriptLines& out) {
  out.add(1, "set_tcp(", to_script(out.context().T_F_T), ")");
  if (const auto& payload = out.context().payload)
    out.add(1, "set_payload(", to_script(*payload), ", ", to_script(out.context().p_F_com), ")");
}

/// Where and how a motion ended; the end state comes last.
void end(ScriptLines& out, const std::string& state) {
  out.add(1, "stk_pose = get_actual_tcp_pose()");
  for (int i = 0; i < 6; ++i) out.add(1, "write_output_float_register(", out.reg(i), ", stk_pose[", i, "])");
  out.add(1, "write_output_float_register(", out.reg(6), ", stk_force)");
  out.add(1, "write_output_integer_register(", out.reg(2), ", ", state, ")");
  out.add(0, "end");
}

void define_globals(ScriptLines& out, const JointTrajectory& trajectory) {
  double fastest = 0.0;
  for (const Joints& qd : trajectory.qd) fastest = std::max(fastest, qd.cwiseAbs().maxCoeff());
  out.add(1, "global stk_dt = ", out.step_time());
  const double lag_limit = kHoldLag + 2 * kLookahead * fastest;
  out.add(1, "global stk_lag_limit = ", to_script(lag_limit));
  out.add(1, "global stk_lag_end = ", to_script(kChase * lag_limit));
  out.add(1, "global stk_t = 0.0");
  out.add(1, "global stk_end = ", number(ScriptEnd::kRunning));
  out.add(1, "global stk_force = 0.0");
  out.add(1, "global stk_q0 = ", to_script(trajectory.q.front()));
  out.add(1, "global stk_v0 = ", to_script(trajectory.qd.front()));
}

/// The largest distance of a joint from its commanded position.
void define_lag(ScriptLines& out) {
  out.add(1, "def stk_lag(q):");
  out.add(2, "local a = get_actual_joint_positions()");
  out.add(2, "local most = 0.0");
  out.add(2, "local i = 0");
  out.add(2, "while i < 6:");
  out.add(3, "if norm(q[i] - a[i]) > most:");
  out.add(4, "most = norm(q[i] - a[i])");
  out.add(3, "end");
  out.add(3, "i = i + 1");
  out.add(2, "end");
  out.add(2, "return most");
  out.add(1, "end");
}

/// One cubic Hermite piece, a servoj a control step. The clock of the path waits while the arm lags behind it
/// (speed slider, pause), so that nothing jumps afterwards. An arm that is further away than a waiting path
/// leaves it (moved in a pause, held back) would jump, for servoj has no speed limit: that ends the program.
void define_piece(ScriptLines& out, bool guarded) {
  out.add(1, "def stk_to(knot, h, q1, v1):");
  out.add(2, "while (stk_t < h) and (stk_end == 0):");
  out.add(3, "local s = stk_t / h");
  out.add(3, "local a = (2.0 * s - 3.0) * s * s + 1.0");
  out.add(3, "local b = ((s - 2.0) * s + 1.0) * s * h");
  out.add(3, "local c = (3.0 - 2.0 * s) * s * s");
  out.add(3, "local d = (s - 1.0) * s * s * h");
  std::string q;
  for (int j = 0; j < 6; ++j)
    q += concat(j > 0 ? ", " : "", "a * stk_q0[", j, "] + b * stk_v0[", j, "] + c * q1[", j, "] + d * v1[", j,
                "]");
  out.add(3, "local q = [", q, "]");
  out.add(3, "servoj(q, t=stk_dt, lookahead_time=", to_script(kLookahead), ", gain=", to_script(kGain), ")");
  if (guarded) out.add(3, "stk_guard()");
  out.add(3, "local lag = stk_lag(q)");
  out.add(3, "if lag < stk_lag_limit:");
  out.add(4, "stk_t = stk_t + stk_dt");
  out.add(3, "elif (lag > stk_lag_end) and (stk_end == 0):");
  out.add(4, "stk_end = ", number(ScriptEnd::kFellBehind));
  out.add(3, "end");
  out.add(2, "end");
  out.add(2, "stk_t = stk_t - h");
  out.add(2, "stk_q0 = q1");
  out.add(2, "stk_v0 = v1");
  out.add(2, "write_output_integer_register(", out.reg(1), ", knot)");
  out.add(1, "end");
}

void follow_pieces(ScriptLines& out, const JointTrajectory& trajectory, bool guarded) {
  for (std::size_t k = 1; k < trajectory.time.size(); ++k)
    out.add(1, "stk_to(", k, ", ", to_script(trajectory.time[k] - trajectory.time[k - 1]), ", ",
            to_script(trajectory.q[k]), ", ", to_script(trajectory.qd[k]), ")");
  out.add(1, "local goal = ", to_script(trajectory.q.back()));
  out.add(1, "local gap = stk_lag(goal)");
  out.add(1, "while (stk_end == 0) and (gap > ", to_script(kArrived), "):");
  out.add(2, "if gap > stk_lag_end:");
  out.add(3, "stk_end = ", number(ScriptEnd::kFellBehind));
  out.add(2, "else:");
  out.add(3, "servoj(goal, t=stk_dt, lookahead_time=", to_script(kLookahead), ", gain=", to_script(kGain),
          ")");
  if (guarded) out.add(3, "stk_guard()");
  out.add(3, "gap = stk_lag(goal)");
  out.add(2, "end");
  out.add(1, "end");
  out.add(1, "stopj(", to_script(out.options().stop_acceleration), ")");
}

/// The program's own end, unless something ended it before.
void end_well(ScriptLines& out, ScriptEnd state) {
  out.add(1, "if stk_end == 0:");
  out.add(2, "stk_end = ", number(state));
  out.add(1, "end");
  end(out, "stk_end");
}

void require_trajectory(const JointTrajectory& trajectory) {
  const std::string fault = malformed(trajectory);
  require(fault.empty(), fault);
}

}  // namespace

int first_register(const UrVersion& version) {
  return version.has(kUpperRegisters3, kUpperRegisters5) ? 24 : 0;
}

std::string script_name(int run) {
  return concat("stonestack_", run);
}

std::string write_trajectory(const JointTrajectory& trajectory, const ScriptContext& context) {
  require_trajectory(trajectory);
  ScriptLines out(context);
  begin(out);
  watch_heartbeat(out);
  set_tool(out);
  define_globals(out, trajectory);
  define_lag(out);
  define_piece(out, false);
  follow_pieces(out, trajectory, false);
  end_well(out, ScriptEnd::kDone);
  return out.take();
}

std::string write_guarded(const JointTrajectory& trajectory, const ScriptGuard& guard,
                          const ScriptContext& context) {
  require_trajectory(trajectory);
  require(guard.threshold > 0 && std::abs(guard.n_B_direction.norm() - 1) < 1e-6,
          "a guard needs a positive threshold and a unit direction, got ", guard.threshold, " N and length ",
          guard.n_B_direction.norm());
  ScriptLines out(context);
  begin(out);
  watch_heartbeat(out);
  set_tool(out);
  define_globals(out, trajectory);
  define_lag(out);
  define_guard(out, guard);
  define_piece(out, true);
  take_zero(out);
  follow_pieces(out, trajectory, true);
  comply(out, guard);
  end_well(out, ScriptEnd::kNoContact);
  return out.take();
}

std::string write_stop(const ScriptContext& context) {
  ScriptLines out(context);
  begin(out);
  out.add(1, "stopj(", to_script(context.options.stop_acceleration), ")");
  out.add(1, "global stk_force = 0.0");
  end(out, concat(number(ScriptEnd::kDone)));
  return out.take();
}

std::string write_settings(const ScriptContext& context) {
  ScriptLines out(context);
  begin(out);
  set_tool(out);
  out.add(1, "sync()");
  out.add(1, "global stk_force = 0.0");
  end(out, concat(number(ScriptEnd::kDone)));
  return out.take();
}

std::string script_line(const std::string& script, int line) {
  std::istringstream in(script);
  std::string text;
  for (int i = 0; i < line; ++i)
    if (!std::getline(in, text)) return {};
  return text.substr(std::min(text.find_first_not_of(' '), text.size()));
}

}  // namespace stonestack::hardware
