#include "stonestack/report/record_run.hpp"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "hardware/cell_config.hpp"
#include "report/known_cells.hpp"
#include "report/perform_run.hpp"
#include "report/run_folder.hpp"
#include "report/run_order.hpp"
#include "stacking/model_field.hpp"
#include "stacking/resume_point.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

bool is_real(const RunOrder& order) {
  return order.cell && !order.cell->simulate;
}

/// Decides, and says on the log why.
bool is_slow(const RunOrder& order) {
  const std::string slow = concat("the tool moves at ", kSlowToolSpeed, " m/s at most");
  if (order.speed == RunSpeed::kSlow) {
    log_info(slow + ", as --slow asks");
    return true;
  }
  if (order.speed == RunSpeed::kFull || !is_real(order) || is_known_cell(order.cell->path)) return false;
  log_info(concat(slow, ": no run on hardware was completed yet with ", order.cell->path,
                  " as it stands; --full-speed lifts this"));
  return true;
}

/// A run that moved a stone to where it should be and was not broken off.
bool is_completed(const RunResult& result) {
  if (result.end == RunEnd::kStopped || result.end == RunEnd::kInterrupted || result.end == RunEnd::kFailed)
    return false;
  return std::any_of(result.placements.begin(), result.placements.end(), [](const PlacementRecord& placed) {
    return placed.outcome == PlacementRecord::Outcome::kPlaced;
  });
}

/// Planner and gate take the limit from the cell, or from the robot where there is none.
RunOrder at_slow_speed(RunOrder order) {
  order.robot.tool_speed = std::min(order.robot.tool_speed, kSlowToolSpeed);
  if (!order.cell) return order;
  double& limit = order.cell->cell().limits.tool_speed;
  limit = std::min(limit, kSlowToolSpeed);
  return order;
}

RecordedRun perform_at_speed(const RunOrder& order, const Catalogue& catalogue, const RecordFolder& folder,
                             const RunMode& mode) {
  const CellFile* const file = order.cell ? &*order.cell : nullptr;
  if (file != nullptr) (void)with_option_gripper(to_layout(file->cell()), order.run.build.gripper, true);
  if (is_real(order))
    return perform_real(order.run, catalogue, *file, folder, order.version, order.view, mode);
  const RobotModel robot = file == nullptr ? order.robot : read_cell_robot(file->cell());
  const CellLayout layout = with_option_gripper(file == nullptr ? CellLayout{} : to_layout(file->cell()),
                                                order.run.build.gripper, file != nullptr);
  const auto present = draw_stones(catalogue, order.per_run, order.run.seed, gripper_of(layout), robot);
  return perform(order.run, catalogue, robot, present, folder, order.version, nullptr, file, order.view,
                 mode);
}

/// A run that fails before it begins leaves nothing behind that could go on.
RecordedRun record_at_speed(const RunOrder& order, const Catalogue& catalogue, const RecordFolder& folder) {
  const bool resumes = !order.resume.empty();
  const RunMode mode{order.dry,   order.before_motion, order.save_catalogue,
                     order.known, order.only_model,    can_resume(order),
                     resumes};
  if (mode.keeps && !resumes) write_order(folder.path(), order, catalogue);
  try {
    return perform_at_speed(order, catalogue, folder, mode);
  } catch (...) {
    std::error_code ignored;
    if (!std::filesystem::exists(folder.path() + stacking::kResumeFile))
      std::filesystem::remove(folder.path() + kOrderFile, ignored);
    throw;
  }
}

/// Refuses, before anything moves or is written, what cannot be modelled.
void check_unseen(const RunOrder& order) {
  if (!order.resume.empty()) return;  // its stones are modelled
  const bool unseen = order.run.build.unseen;
  require(!unseen || !order.dry,
          "a dry run moves nothing, but stones that nobody scanned are modelled by moving "
          "the camera around them: leave out --dry-run or --unseen");
  require(unseen || (order.save_catalogue.empty() && !order.only_model),
          "only stones that nobody scanned are modelled and saved: add --unseen");
  require(unseen || order.known.empty(),
          "without --unseen all stones are known: name their folder with --catalogue in place of --known");
  std::vector<std::string> known;
  if (!order.known.empty())
    for (const Stone& stone : read_catalogue(order.known).stones) known.push_back(stone.name);
  if (order.save_catalogue.empty()) return;
  std::error_code not_there;
  require(order.known.empty() || !std::filesystem::equivalent(order.known, order.save_catalogue, not_there),
          "--save-catalogue names the folder of --known: save to another one");
  const std::string first = stacking::modelled_name(known);
  require(
      order.replace_stones || !std::filesystem::exists(std::filesystem::path(order.save_catalogue) / first),
      "stone '", first, "' is in ", order.save_catalogue, " already; give another folder, or move it away");
  require_writable(order.save_catalogue + "/stone.yaml");
}

/// Refuses, before the simulated cell is filled, a wall of more stones than will lie in its field.
void check_wall(const RunOrder& order, const Catalogue& catalogue) {
  if (order.run.build.wall.empty() || is_real(order) || !order.resume.empty()) return;
  const std::vector<int> courses = read_wall_target(order.run.build.wall).courses;
  const int asked = std::accumulate(courses.begin(), courses.end(), 0);
  const auto all = static_cast<int>(catalogue.stones.size());
  const int present = std::min(order.per_run, all);
  require(asked <= present, "--wall ", order.run.build.wall, " asks for ", asked, " stones, ", present,
          " lie in the field; give --per-run ", asked,
          asked <= all ? "" : concat(" and a catalogue of more than ", all, ", as `scan --generate` makes"));
}

}  // namespace

RecordedRun record_run(const RunOrder& order, const Catalogue& catalogue) {
  check_unseen(order);
  check_wall(order, catalogue);
  stacking::check_options(order.run.build);
  const RecordFolder folder =
      order.resume.empty() ? take_run_folder(order.out, order.run.seed) : take_resumed_folder(order.resume);
  RecordedRun done = record_at_speed(is_slow(order) ? at_slow_speed(order) : order, catalogue, folder);
  const RunEnd end = done.report.result.end;
  done.resumable = can_resume(order) && (end == RunEnd::kInterrupted || end == RunEnd::kStopped) &&
                   std::filesystem::exists(folder.path() + stacking::kResumeFile);
  if (is_real(order) && is_completed(done.report.result)) note_known_cell(order.cell->path);
  return done;
}

}  // namespace stonestack::report
