#pragma once
#include <functional>
#include <string>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack {

/// Options of the whole loop.
struct BuildOptions {
  DetectionOptions detection;
  SearchOptions search;
  MotionOptions motion;
  int most_stones = 0;  ///< stop at this height; 0: all that are seen
};
[[nodiscard]] FieldList fields(BuildOptions& options);

/// One attempted placement.
struct PlacementRecord {
  enum class Outcome { kPlaced, kMoved, kFallen, kNotPicked, kLost };
  std::string stone;
  Placement planned;
  std::optional<Pose> T_W_O_measured;
  Outcome outcome = Outcome::kPlaced;
  std::string note;
};
[[nodiscard]] std::string to_text(PlacementRecord::Outcome outcome);

/// Host seconds (detection, search, planning) and arm seconds (motion, by the cell's clock).
struct StageSeconds {
  double detection = 0, search = 0, planning = 0, motion = 0;
};

/// What a run did, as the program knows it.
struct RunResult {
  int height = 0;  ///< stones that the last observation shows stacked
  std::vector<PlacementRecord> placements;
  std::string ended;  ///< why it stopped
  StageSeconds seconds;
  std::vector<PlacedStone> stack;  ///< as last measured
};

/// The paper's loop (figure 1): observe, search, plan, execute, observe again, judge, until no pose is
/// feasible, a placement failed, or all stones are placed.
[[nodiscard]] RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                                    const BuildOptions& options,
                                    const std::function<void(const std::string&)>& report);

}  // namespace stonestack
