#include "stacking/replay.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "hardware/cell_config.hpp"
#include "stacking/device_tape.hpp"
#include "stacking/state_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;

constexpr const char* kStartSchema = "stonestack.start/1";
constexpr const char* kReplaySchema = "stonestack.replay/1";
constexpr std::size_t kMaxStart = std::size_t{1} << 24;
constexpr std::size_t kMaxLines = std::size_t{1} << 28;

/// Rotation and translation as they are: a quaternion would round them.
json exact_json(const Pose& pose) {
  json list = json::array();
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 4; ++column) list.push_back(pose.matrix()(row, column));
  return list;
}
Pose exact_pose_of(const json& j) {
  Pose pose = Pose::Identity();
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 4; ++column)
      pose.matrix()(row, column) = j.at(static_cast<std::size_t>(4 * row + column)).get<double>();
  return pose;
}

/// Start of a replay.
struct Start {
  Catalogue catalogue;
  RobotModel robot;
  State state;
  long first_line = 0;  ///< of the journal
};

/// The stones that the run began with: those that it modelled later may lie in the same folder.
Catalogue known_at_start(const Catalogue& all, const json& start) {
  if (!start.contains("stones")) return all;
  Catalogue known;
  known.path = all.path;
  for (const json& name : start.at("stones")) known.stones.push_back(all[all.index(name.get<std::string>())]);
  return known;
}

Start read_start(const ReplayTask& task) {
  const std::string folder = task.run + kInputsFolder, path = folder + "/start.json",
                    state = folder + "/state.json";
  if (!std::filesystem::is_directory(task.run))
    throw FileError(task.run, "is no folder", "give that of a run");
  if (!std::filesystem::exists(folder))
    throw FileError(folder, "is not there: the run did not keep its inputs",
                    "record one with `run --set run.save_states=true`");
  try {
    const json j = json::parse(read_file(path, kMaxStart));
    require(j.at("schema").get<std::string>() == kStartSchema, "its schema is not ", kStartSchema);
    const StateHeader header = read_state_header(state);
    const std::string stones = task.catalogue.empty() ? header.catalogue : task.catalogue;
    Start start;
    start.catalogue = known_at_start(read_catalogue(stones.empty() ? data_path("stones") : stones), j);
    start.robot = task.cell.empty() ? read_robot(header.robot) : read_cell_robot(CellConfig(task.cell));
    if (const json& speed = j.at("tool_speed"); !speed.is_null())
      start.robot.tool_speed = speed.get<double>();
    start.state = read_state(state, start.catalogue);
    start.first_line = j.at("journal").get<long>();
    CellLayout& layout = start.state.world.layout;
    layout.T_W_R = exact_pose_of(j.at("T_W_R"));
    layout.T_F_T = exact_pose_of(j.at("T_F_T"));
    layout.T_T_C = exact_pose_of(j.at("T_T_C"));
    for (std::size_t k = 0; k < layout.obstacles.size(); ++k)
      layout.obstacles[k].T_W_O = exact_pose_of(j.at("obstacles").at(k));
    return start;
  } catch (const json::exception& problem) {
    throw FileError(path, concat("is no start of a run: ", problem.what()),
                    "give the folder of a run with run.save_states=true");
  }
}

/// Lines of a journal up to where the run was broken off, without a torn last one and without what differs
/// from run to run: number, time, checksum. Earlier versions did not write where the arm was.
std::vector<std::string> lines_of(const std::string& path) {
  std::istringstream in(read_file(path, kMaxLines));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line) && !in.eof();) {
    json j = json::parse(line, nullptr, false);
    if (!j.is_object())
      throw FileError(path, concat("line ", lines.size() + 1, " is no JSON object"),
                      "see what stonestack inspect says of it");
    if (j.value("kind", "") == "resumed") break;
    for (const char* other : {"seq", "time", "arm", "crc"}) j.erase(other);
    lines.push_back(j.dump());
  }
  return lines;
}

}  // namespace

void write_start(const std::string& folder, const CellLayout& layout, const Catalogue& catalogue,
                 const RobotModel& robot, const BuildOptions& options, const Journal* journal) {
  WorldEstimate world;
  world.layout = layout;
  write_state(folder + "/state.json", world, make_memory(options), {&catalogue, &robot, {}, {}, {}}, options);
  json stones = json::array(), obstacles = json::array();
  for (const Stone& stone : catalogue.stones) stones.push_back(stone.name);
  for (const Obstacle& obstacle : layout.obstacles) obstacles.push_back(exact_json(obstacle.T_W_O));
  const json start{{"schema", kStartSchema},
                   {"journal", journal == nullptr ? 0 : journal->lines()},
                   {"stones", stones},
                   {"tool_speed", robot.tool_speed},
                   {"T_W_R", exact_json(layout.T_W_R)},
                   {"T_F_T", exact_json(layout.T_F_T)},
                   {"T_T_C", exact_json(layout.T_T_C)},
                   {"obstacles", obstacles}};
  write_file(folder + "/start.json", start.dump(1) + "\n");
}

Replay replay_run(const ReplayTask& task, const std::function<void(const std::string&)>& report) {
  Start start = read_start(task);
  RecordedTape tape(task.run + kInputsFolder);
  std::vector<std::string> recorded = lines_of(task.run + "/journal.jsonl");
  require(static_cast<std::size_t>(start.first_line) <= recorded.size(), task.run, "/journal.jsonl has ",
          recorded.size(), " lines, and the replay starts after ", start.first_line);
  recorded.erase(recorded.begin(), recorded.begin() + start.first_line);

  Replay replay;
  replay.journal = task.run + "/replay.jsonl";
  write_file(replay.journal, "");
  Journal journal(replay.journal);
  BuildHooks hooks;
  hooks.journal = &journal;
  std::size_t answered = 0;
  tape.at_end = [&] { answered = static_cast<std::size_t>(journal.lines()); };
  TapedDevices devices(start.state.world.layout, tape);
  Cell cell = devices.cell();
  BuildOptions options = start.state.options;
  options.save_states = false;
  Catalogue named = start.catalogue;  // and what is modelled on the way
  hooks.listener = [&](const Event& event) {
    if (const std::string line = to_text(event, named); report && !line.empty()) report(line);
  };
  (void)build_resumable(cell, start.catalogue, start.robot, options, hooks, {}, false,
                        [&](const Stone& stone, const ModelledStone&) { named.stones.push_back(stone); });

  std::vector<std::string> now = lines_of(replay.journal);
  replay.complete = !tape.ran_out();
  if (!replay.complete) now.resize(std::min(now.size(), answered));  // the rest is for want of answers
  replay.recorded = static_cast<long>(recorded.size());
  const std::size_t common = std::min(now.size(), recorded.size());
  std::size_t same = 0;
  while (same < common && now[same] == recorded[same]) ++same;
  replay.same = static_cast<long>(same);
  if (same < common)
    replay.difference = concat("recorded: ", recorded[same], "\nnow:      ", now[same]);
  else if (replay.complete && now.size() != recorded.size())
    replay.difference = concat(now.size(), " lines in place of ", recorded.size());
  return replay;
}

std::string replay_json(const Replay& replay) {
  return nlohmann::ordered_json{{"schema", kReplaySchema},     {"same", replay.difference.empty()},
                                {"lines", replay.same},        {"recorded", replay.recorded},
                                {"complete", replay.complete}, {"difference", replay.difference},
                                {"journal", replay.journal}}
             .dump(2) +
         "\n";
}

std::string replay_text(const Replay& replay) {
  const bool same = replay.difference.empty();
  return concat(same ? "the same: " : "differs after ", replay.same, " of ", replay.recorded,
                " lines of the journal", replay.complete ? "" : "; the record of the devices ends there",
                same ? "" : "\n" + replay.difference, "\njournal: ", replay.journal, '\n');
}

}  // namespace stonestack::stacking
