#include "hardware/ur/script_guard.hpp"

#include "hardware/constants.hpp"

namespace stonestack::hardware {
namespace {

constexpr UrVersion kDamping3{3, 5, 0, 0}, kDamping5{5, 0, 0, 0};
constexpr double kDamping = 0.1;      // of force mode, close to the controller's default
constexpr double kSideways = 0.05;    // m and rad that force mode may leave the other axes
constexpr double kStandstill = 0.02;  // s that force mode needs before it

}  // namespace

void define_guard(ScriptLines& out, const ScriptGuard& guard) {
  const ScriptOptions& o = out.options();
  const Eigen::Vector3d& n = guard.n_B_direction;
  out.add(1, "global stk_count = read_input_integer_register(", out.reg(1), ")");
  out.add(1, "global stk_silent = 0.0");
  out.add(1, "global stk_fresh = False");
  out.add(1, "global stk_zero = 0.0");
  out.add(1, "global stk_above = 0");
  out.add(1, "def stk_read_force():");
  out.add(2, "local count = read_input_integer_register(", out.reg(1), ")");
  out.add(2, "stk_fresh = count != stk_count");
  out.add(2, "stk_silent = stk_silent + stk_dt");
  out.add(2, "if stk_fresh:");
  out.add(3, "stk_count = count");
  out.add(3, "stk_silent = 0.0");
  out.add(3, "stk_force = 0.0 - (", to_script(n.x()), " * read_input_float_register(", out.reg(0), ") + ",
          to_script(n.y()), " * read_input_float_register(", out.reg(1), ") + ", to_script(n.z()),
          " * read_input_float_register(", out.reg(2), ")) - stk_zero");
  out.add(2, "end");
  out.add(2, "if stk_silent > ", to_script(o.force_stale), ":");
  out.add(3, "stk_end = ", number(ScriptEnd::kStaleForce));
  out.add(2, "end");
  out.add(1, "end");
  out.add(1, "def stk_guard():");
  out.add(2, "stk_read_force()");
  out.add(2, "if stk_fresh:");
  out.add(3, "write_output_float_register(", out.reg(6), ", stk_force)");
  out.add(3, "stk_above = stk_above + 1");
  out.add(3, "if stk_force <= ", to_script(guard.threshold), ":");
  out.add(4, "stk_above = 0");
  out.add(3, "end");
  out.add(3, "if (stk_above >= ", o.contact_samples, ") and (stk_end == 0):");
  out.add(4, "stk_end = ", number(ScriptEnd::kContact));
  out.add(3, "end");
  out.add(2, "end");
  out.add(1, "end");
}

void take_zero(ScriptLines& out) {
  const int samples = kForceSamples;
  out.add(1, "local sum = 0.0");
  out.add(1, "local taken = 0");
  out.add(1, "while (taken < ", samples, ") and (stk_end == 0):");
  out.add(2, "stk_read_force()");
  out.add(2, "if stk_fresh:");
  out.add(3, "sum = sum + stk_force");
  out.add(3, "taken = taken + 1");
  out.add(2, "end");
  out.add(2, "sync()");
  out.add(1, "end");
  out.add(1, "stk_zero = sum / ", to_script(samples));
  out.add(1, "stk_force = 0.0");
}

void comply(ScriptLines& out, const ScriptGuard& guard) {
  const ScriptOptions& o = out.options();
  if (o.comply_time <= 0) return;
  Pose T_B_task = Pose::Identity();
  T_B_task.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), guard.n_B_direction).toRotationMatrix();
  const std::string side = to_script(kSideways);
  out.add(1, "if stk_end == ", number(ScriptEnd::kContact), ":");
  out.add(2, "sleep(", to_script(kStandstill), ")");
  if (out.context().version.has(kDamping3, kDamping5))
    out.add(2, "force_mode_set_damping(", to_script(kDamping), ")");
  out.add(2, "force_mode(", to_script(T_B_task), ", [0, 0, 1, 0, 0, 0], [0.0, 0.0, ", to_script(kComplyForce),
          ", 0.0, 0.0, 0.0], 2, [", side, ", ", side, ", ", to_script(kComplySpeed), ", ", side, ", ", side,
          ", ", side, "])");
  out.add(2, "local left = ", to_script(o.comply_time));
  out.add(2, "while left > 0.0:");
  out.add(3, "sync()");
  out.add(3, "left = left - stk_dt");
  out.add(2, "end");
  out.add(2, "end_force_mode()");
  out.add(2, "stopl(", to_script(o.stop_acceleration), ")");
  out.add(1, "end");
}

}  // namespace stonestack::hardware
