#pragma once
#include <string>
#include <vector>

#include "stonestack/hardware/cell.hpp"
#include "stonestack/stacking/build_options.hpp"
#include "stonestack/stacking/event.hpp"
#include "stonestack/stacking/journal.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stacking/run_memory.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// Host seconds for which the arm waited (detection, search, planning) and arm seconds (motion, by the cell's
/// clock). What was detected and searched beside a motion, as far as it was no longer than that, is counted
/// apart.
struct StageSeconds {
  double detection = 0, search = 0, planning = 0, motion = 0, beside_motion = 0;
};

/// State of arm and gripper at one time, as the devices reported it.
struct MotionSample {
  double time = 0.0;  ///< of the cell's clock [s]
  Joints q = Joints::Zero();
  double opening = 0.155;  ///< between the finger pads [m]
  double spacing = 0.073;  ///< of fingers B and C [m]
  double force = 0.0;      ///< at the wrist, last reading [N]
  bool holds = false;      ///< the fingers were stopped by an object
};

/// History of a run over time. Between two samples the joints move in a straight line.
struct Timeline {
  std::vector<MotionSample> samples;
  std::vector<double> event_time;  ///< of each event of the result [s]
};

/// Result of a run, as the program knows it: made from its events.
struct RunResult {
  using End = RunEnd;
  int height = 0;  ///< stones that the last observation shows stacked
  std::vector<PlacementRecord> placements;
  std::string ended;  ///< why it stopped
  End end = End::kAllPlaced;
  StageSeconds seconds;
  WorldEstimate world;  ///< as last observed
  std::vector<Event> events;
  Timeline timeline;
};

/// Listeners of a run.
struct BuildHooks {
  Listener listener;           ///< every event, from one thread
  Journal* journal = nullptr;  ///< intents and outcomes; none: not kept
  std::string states_folder;   ///< where `run.save_states` writes; empty: nowhere
};

/// The paper's loop (figure 1): observe, choose, plan, execute, observe again, judge, learn, until no pose is
/// feasible, a placement failed, or all stones are placed. Stops the arm and returns what was done when
/// interrupted or when a device fails. The journal's last line, of kind "end", says how the run ended and
/// why.
[[nodiscard]] RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                                    const BuildOptions& options, const BuildHooks& hooks = {});

}  // namespace stonestack::stacking

#pragma GCC visibility pop
