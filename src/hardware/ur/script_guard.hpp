#pragma once
#include "hardware/ur/script_lines.hpp"

namespace stonestack::hardware {

/// Defines stk_guard(), to be called at every control step: sets stk_end on contact or when the streamed
/// force falls silent. `stk_fresh` is true if the last call saw a new sample.
void define_guard(ScriptLines& out, const ScriptGuard& guard);
/// Takes the mean of the first samples, at rest, for no force.
void take_zero(ScriptLines& out);
/// After contact: lets the stone find its seat under a light push.
void comply(ScriptLines& out, const ScriptGuard& guard);

}  // namespace stonestack::hardware
