#include <array>
#include <cmath>

#include "geometry/json_file.hpp"
#include "report/experiment_folder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr const char* kRemedy = "begin a new experiment in another folder";

/// The value under `key`, which must be there and of that kind.
const json& entry(const json& map, const char* key, bool (json::*is)() const noexcept,
                  const std::string& path) {
  if (!map.is_object() || !map.contains(key) || !(map.at(key).*is)())
    throw FileError(path, concat(key, " is missing or of another kind"), kRemedy);
  return map.at(key);
}

std::string text_of(const json& map, const char* key, const std::string& path) {
  return entry(map, key, &json::is_string, path).get<std::string>();
}

int count_of(const json& map, const char* key, const std::string& path) {
  return static_cast<int>(number_of(map, key, 0.0, 2147483647.0, path));
}

double seconds_of(const json& map, const char* key, const std::string& path) {
  return number_of(map, key, 0.0, 1e9, path);
}

/// The one of `values` whose text it is.
template <class Value, std::size_t N>
Value named(const std::array<Value, N>& values, const std::string& text, const std::string& path) {
  for (const Value value : values)
    if (to_text(value) == text) return value;
  throw FileError(path, concat("'", text, "' is no end and no outcome of a run"), kRemedy);
}

RunResult::End end_of(const std::string& text, const std::string& path) {
  using End = RunResult::End;
  return named(std::array{End::kAllPlaced, End::kHeightReached, End::kNoPose, End::kNoPlan,
                          End::kPlacementFailed, End::kNothingSeen, End::kStopped, End::kInterrupted},
               text, path);
}

PlacementRecord::Outcome outcome_of(const std::string& text, const std::string& path) {
  using Outcome = PlacementRecord::Outcome;
  return named(
      std::array{Outcome::kPlaced, Outcome::kMoved, Outcome::kFallen, Outcome::kNotPicked, Outcome::kDropped,
                 Outcome::kLost, Outcome::kUnstacked, Outcome::kReoriented, Outcome::kPushed},
      text, path);
}

Pose pose_of(const json& map, const std::string& path) {
  const auto number = [&](const char* key) { return number_of(map, key, -1e6, 1e6, path); };
  const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
  if (std::abs(q.norm() - 1.0) > 1e-6) throw FileError(path, "a quaternion is not of unit length", kRemedy);
  return make_pose(Eigen::Vector3d(number("x"), number("y"), number("z")), q);
}

PlacementRecord placement_of(const json& map, const std::string& path) {
  PlacementRecord record;
  record.stone = text_of(map, "stone", path);
  record.planned.T_W_O = pose_of(entry(map, "T_W_O_planned", &json::is_object, path), path);
  if (map.contains("T_W_O_measured") && !map.at("T_W_O_measured").is_null())
    record.T_W_O_measured = pose_of(map.at("T_W_O_measured"), path);
  record.planned.cost = number_of(map, "cost", -1e9, 1e9, path);
  const json& terms = entry(map, "terms", &json::is_object, path);
  for (const auto& [name, value] : terms.items())  // JSON has no infinity: written as null
    record.planned.terms[name] = value.is_null() ? HUGE_VAL : number_of(terms, name, -1e9, 1e9, path);
  record.planned.predicted_success = number_of(map, "predicted_success", 0.0, 1.0, path);
  record.outcome = outcome_of(text_of(map, "outcome", path), path);
  record.note = text_of(map, "note", path);
  if (map.contains("level")) record.level = count_of(map, "level", path);  // older records have none
  if (map.contains("course")) record.course = count_of(map, "course", path);
  return record;
}

TruthReport truth_of(const json& map, const std::string& path) {
  TruthReport truth;
  truth.height = count_of(map, "height", path);
  truth.stands = entry(map, "stands", &json::is_boolean, path).get<bool>();
  truth.seconds = seconds_of(map, "seconds", path);
  truth.shift = number_of(map, "shift_m", 0.0, 1e9, path);
  truth.turn = number_of(map, "turn_rad", 0.0, 1e9, path);
  truth.note = text_of(map, "note", path);
  if (!map.contains("engines")) return truth;  // as older records
  for (const json& verdict : entry(map, "engines", &json::is_array, path))
    truth.engines.push_back({text_of(verdict, "engine", path), count_of(verdict, "height", path),
                             seconds_of(verdict, "seconds", path),
                             number_of(verdict, "shift_m", 0.0, 1e9, path),
                             number_of(verdict, "turn_rad", 0.0, 1e9, path), text_of(verdict, "note", path)});
  return truth;
}

WallMetrics wall_of(const json& map, const std::string& path) {
  WallMetrics wall;
  for (const auto& [key, count] : {std::pair<const char*, int*>{"placed", &wall.placed},
                                   {"asked", &wall.asked},
                                   {"joints", &wall.joints},
                                   {"open_joints", &wall.open_joints}})
    *count = count_of(map, key, path);
  for (const auto& [key, number] : {std::pair<const char*, double*>{"length_m", &wall.length},
                                    {"height_m", &wall.height},
                                    {"width_m", &wall.width},
                                    {"fill", &wall.fill},
                                    {"face", &wall.face},
                                    {"flatness_m", &wall.flatness},
                                    {"margin_g", &wall.margin}})
    *number = number_of(map, key, 0.0, 1e9, path);
  if (map.contains("to_span_m")) {  // older files have none
    wall.spanned = number_of(map, "spanned_m", 0.0, 1e9, path);
    wall.to_span = number_of(map, "to_span_m", 0.0, 1e9, path);
  }
  return wall;
}

std::vector<std::string> names_of(const json& map, const char* key, const std::string& path) {
  std::vector<std::string> names;
  for (const json& name : entry(map, key, &json::is_array, path)) {
    if (!name.is_string()) throw FileError(path, concat(key, " holds something else than names"), kRemedy);
    names.push_back(name.get<std::string>());
  }
  return names;
}

Shard shard_of(const json& map, const std::string& path) {
  const Shard shard{count_of(map, "index", path), count_of(map, "count", path)};
  if (shard.index < 1 || shard.index > shard.count)
    throw FileError(path, concat("there is no shard ", to_text(shard)), kRemedy);
  return shard;
}

RunReport report_of(const json& map, const std::string& path) {
  RunReport report;
  RunResult& result = report.result;
  result.height = count_of(map, "height", path);
  for (const json& placement : entry(map, "placements", &json::is_array, path))
    result.placements.push_back(placement_of(placement, path));
  result.end = end_of(text_of(map, "ended", path), path);
  result.ended = text_of(map, "reason", path);
  report.robot = text_of(map, "robot", path);
  report.seed = count_of(map, "seed", path);
  if (map.contains("cell")) {
    const json& cell = map.at("cell");
    if (const std::string name = text_of(cell, "name", path); name != "real") report.cell = name;
    if (cell.contains("safety_checksum")) report.safety_checksum = text_of(cell, "safety_checksum", path);
    for (const json& change : entry(cell, "changes", &json::is_array, path)) {
      if (!change.is_string()) throw FileError(path, "cell.changes holds something else than texts", kRemedy);
      report.cell_changes.push_back(change.get<std::string>());
    }
  }
  report.present = names_of(map, "stones", path);
  const json& seconds = entry(map, "seconds", &json::is_object, path);
  result.seconds.detection = seconds_of(seconds, "detection", path);
  result.seconds.search = seconds_of(seconds, "search", path);
  result.seconds.planning = seconds_of(seconds, "planning", path);
  result.seconds.motion = seconds_of(seconds, "motion", path);
  result.seconds.beside_motion = seconds_of(seconds, "beside_motion", path);
  if (map.contains("wall")) result.wall = wall_of(entry(map, "wall", &json::is_object, path), path);
  if (map.contains("truth")) report.truth = truth_of(map.at("truth"), path);
  if (map.contains("version")) report.version = text_of(map, "version", path);
  if (map.contains("picture")) report.picture = text_of(map, "picture", path);
  return report;
}

/// When towers were looked at, and what stood; the former is the same for all runs.
Survival survival_of(const json& map, std::vector<double>* seconds, const std::string& path) {
  Survival survival;
  for (const json& count : entry(map, "standing", &json::is_array, path)) {
    if (!count.is_number_integer())
      throw FileError(path, "standing holds something else than counts", kRemedy);
    survival.standing.push_back(count.get<int>());
  }
  survival.shaken = count_of(map, "after_shake", path);
  const std::size_t times = entry(map, "seconds", &json::is_array, path).size();
  *seconds = numbers_of(map, "seconds", times, path);
  return survival;
}

}  // namespace

Experiment read_experiment(const std::string& path) {
  return experiment_of(read_json(path), path);
}

Experiment experiment_of(const json& file, const std::string& path) {
  if (!file.is_object() || file.value("schema", json()) != "stonestack.experiment/1")
    throw FileError(path, "not the record of an experiment (stonestack.experiment/1)",
                    "name the experiment.json of an experiment's folder");
  Experiment experiment;
  experiment.title = text_of(file, "title", path);
  experiment.per_run = count_of(file, "per_run", path);
  // Older records have none of these.
  if (file.contains("protocol")) experiment.protocol = text_of(file, "protocol", path);
  if (file.contains("new_stones")) {
    experiment.new_stones = count_of(file, "new_stones", path);
    experiment.new_stones_from = text_of(file, "new_stones_from", path);
  }
  if (file.contains("total")) {
    experiment.seed = count_of(file, "seed", path);
    experiment.total = count_of(file, "total", path);
    experiment.shard = shard_of(entry(file, "shard", &json::is_object, path), path);
    experiment.stones = names_of(file, "stones", path);
  }
  int before = 0;
  for (const json& run : entry(file, "runs", &json::is_array, path)) {
    const RunReport report = report_of(run, path);
    const json& survival = entry(run, "survival", &json::is_object, path);
    const int number = file.contains("total") ? count_of(run, "run", path) : before + 1;
    if (number <= before || !experiment.shard.has(number))
      throw FileError(
          path, concat("run ", number, " is after run ", before, " of shard ", to_text(experiment.shard)),
          kRemedy);
    experiment.runs.push_back({report, survival_of(survival, &experiment.survival_seconds, path), number});
    before = number;
  }
  return experiment;
}

}  // namespace stonestack::report
