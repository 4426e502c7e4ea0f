#pragma once
#include "stacking/plan_motion.hpp"

/// Private to stacking/: what follows from an action for the next view and for the memory.
namespace stonestack::stacking {

/// Memory once stones were looked for among what no model shows, or modelled as they stand; `modelled`: what
/// was found.
[[nodiscard]] RunMemory remember_modelled(RunMemory memory, const ModelAnew& action,
                                          const std::vector<PlacedStone>& modelled, const Models& models);
/// Memory after an action was carried out; its effect is not seen yet.
[[nodiscard]] RunMemory remember(RunMemory memory, const WorldEstimate& world, const Action& action,
                                 const MotionPlan& plan, const ExecutionResult& done);
/// The memory after no motion was found for an action: the world is as before.
[[nodiscard]] RunMemory remember_refusal(RunMemory memory, const Action& action, const MotionPlan& plan);

/// Expected view after stones were modelled, each where it was seen: in the place of the one that was
/// modelled where it stands; else as part of a tower, if it came to rest on it or at the site; else in the
/// field.
[[nodiscard]] Expectation expected_modelled(const WorldEstimate& world, const RunMemory& memory,
                                            const ModelAnew& action, const std::vector<PlacedStone>& modelled,
                                            const Models& models);

/// Expected view of the world; `memory` remembers the action.
[[nodiscard]] Expectation expected_after(const WorldEstimate& world, const RunMemory& memory,
                                         const Action& action);

/// Memory without what holds for one world only: for a run that goes on, whose world may have changed.
[[nodiscard]] RunMemory without_world(RunMemory memory);
/// Expected view of the world for a run that goes on: it is as it was, or `memory` has an attempt that nobody
/// knows the end of.
[[nodiscard]] Expectation expected_again(const WorldEstimate& world, const RunMemory& memory);

/// Compares what was seen after an action with what was meant.
[[nodiscard]] PlacementRecord judge(const Attempt& attempt, const WorldEstimate& seen, const Models& models,
                                    const BuildOptions& options);

/// The memory after an observation: of which stones were seen and, unless a stone that is out of sight is
/// looked for first (`next_view`), of how the action ended. An action whose end nobody knows and that changed
/// nothing is forgotten as if it had not begun.
[[nodiscard]] RunMemory learn(RunMemory memory, const WorldEstimate& seen, const Models& models,
                              const BuildOptions& options, const Listener& listener);

/// Memory after the arm stopped during an action: nothing is observed then.
[[nodiscard]] RunMemory learn_of_stop(RunMemory memory, const Models& models, const Listener& listener);

}  // namespace stonestack::stacking
