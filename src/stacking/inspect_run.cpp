#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "stacking/resume_point.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxInspected = std::size_t{1} << 28;

std::string mm(const json& metres) {
  return concat(std::lround(1e3 * metres.get<double>()), " mm");
}
std::string newtons(const json& force) {
  return concat(0.1 * std::round(10.0 * force.get<double>()), " N");
}
std::string stones_of(const json& list) {
  std::string names;
  for (const json& stone : list) names += (names.empty() ? "" : ", ") + stone.at("stone").get<std::string>();
  return names.empty() ? "none" : names;
}
std::string place_of(const json& data) {
  const json& T = data.at("T_W_O");
  return concat(data.at("stone").get<std::string>(), " at (", mm(T.at("x")), ", ", mm(T.at("y")), ", ",
                mm(T.at("z")), ')');
}

using Words = std::string (*)(const json& data);

/// Text of each kind of line, for a person. Measurements of a step are indented below it.
const std::map<std::string, Words>& words() {
  static const std::map<std::string, Words> list{
      {"observed",
       [](const json& d) {
         return "stack: " + stones_of(d.at("stack")) + "; loose: " + stones_of(d.at("loose"));
       }},
      {"camera_mount",
       [](const json& d) {
         return concat("camera mount ", mm(d.at("shift_m")), " beside its calibration, table ",
                       mm(d.at("table_height_m")), " above its plane",
                       d.at("accepted").get<bool>() ? "" : ": not accepted");
       }},
      {"unknown_object",
       [](const json& d) {
         return concat("something unknown at (", mm(d.at("x_m")), ", ", mm(d.at("y_m")), "), ",
                       mm(d.at("highest_m")), " high");
       }},
      {"moved",
       [](const json& d) {
         return concat(d.at("stone").get<std::string>(), " moved by ", mm(d.at("shift_m")));
       }},
      {"target", [](const json& d) { return "place " + place_of(d); }},
      {"reorient", [](const json& d) { return "reorient " + place_of(d); }},
      {"unstack", [](const json& d) { return "unstack " + place_of(d); }},
      {"friction",
       [](const json& d) {
         return concat("friction of ", d.at("stone").get<std::string>(),
                       " on the table: ", 0.01 * std::round(100.0 * d.at("on_table").get<double>()));
       }},
      {"wall",
       [](const json& d) {
         return concat("wall of ", d.at("placed").get<int>(), " stones, ", mm(d.at("height_m")), " high");
       }},
      {"outcome",
       [](const json& d) {
         return concat(d.at("stone").get<std::string>(), ": ", d.at("outcome").get<std::string>());
       }},
      {"resumed",
       [](const json& d) {
         const json& attempt = d.at("attempt");
         return concat("resumed after ", d.at("placements").get<int>(), " placements",
                       attempt.is_null() ? "" : ", in the midst of: " + attempt.get<std::string>());
       }},
      {"end",
       [](const json& d) {
         return concat("end (", d.at("end").get<std::string>(), "): ", d.at("reason").get<std::string>());
       }},
      {"step", [](const json& d) { return "  " + d.at("name").get<std::string>(); }},
      {"hold",
       [](const json& d) {
         return concat("    holds ", newtons(d.at("weight")), " of ", newtons(d.at("expected")), ", ",
                       mm(d.at("off")), " beside the planned point");
       }},
      {"carried",
       [](const json& d) {
         return concat("    carried ", newtons(d.at("weight")), " of ", newtons(d.at("expected")),
                       d.at("held").get<bool>() ? "" : ": lost");
       }},
      {"touch",
       [](const json& d) {
         return d.at("touched").get<bool>() ? concat("    touched with ", newtons(d.at("force")), ", ",
                                                     mm(d.at("above_end_m")), " above the end")
                                            : std::string("    touched nothing");
       }},
      {"released",
       [](const json& d) { return concat("    ", newtons(d.at("left")), " left in the gripper"); }},
      {"gripper_retried", [](const json& d) {
         return "    gripper commanded once more: " + d.at("problem").get<std::string>();
       }}};
  return list;
}

/// The journal of a run as far as it can be read.
struct Inspection {
  std::string text;                  ///< a line each
  std::vector<std::string> damaged;  ///< lines that are not as they were written
  std::string step;                  ///< that began last
  json last = {{"stack", json::array()}, {"loose", json::array()}};  ///< observed last
  json outcomes = json::array(), end;
  long lines = 0;

  void add(const std::string& line) {
    const json j = json::parse(line, nullptr, false);
    const std::string number = concat("line ", ++lines);
    if (is_damaged(line)) damaged.push_back(number + " is not as it was written");
    try {
      if (j.at("seq").get<long>() != lines - 1)
        damaged.push_back(concat(number, " has the sequence number ", j.at("seq").get<long>()));
      const auto kind = j.at("kind").get<std::string>();
      const json& data = j.at("data");
      const auto found = words().find(kind);
      text += (found == words().end() ? kind + " " + data.dump() : found->second(data)) + "\n";
      if (kind == "step") step = data.at("name").get<std::string>();
      if (kind == "observed") last = data;
      if (kind == "outcome") outcomes.push_back(data);
      if (kind == "end") end = data;
      if (kind == "resumed") {  // what was in the midst of being done is judged again
        end = nullptr;
        while (outcomes.size() > data.at("placements").get<std::size_t>())
          outcomes.erase(outcomes.size() - 1);
      }
    } catch (const json::exception&) {
      damaged.push_back(number + " is no line of a journal");
    }
  }
};

/// Is what a resume needs in the folder, of a run that did not come to an end of its own?
bool can_go_on(const std::string& folder, const json& end) {
  if (!std::filesystem::exists(folder + kResumeFile)) return false;
  if (end.is_null()) return true;
  const auto how = end.at("end").get<std::string>();
  return how == to_text(RunEnd::kInterrupted) || how == to_text(RunEnd::kStopped) ||
         how == to_text(RunEnd::kFailed);
}

json names_of(const json& stones) {
  json names = json::array();
  for (const json& stone : stones) names.push_back(stone.at("stone"));
  return names;
}

}  // namespace

RunInspection inspect_run(const std::string& folder) {
  const std::string path = folder + "/journal.jsonl";
  if (!std::filesystem::exists(path)) throw FileError(path, "is not there", "give the folder of a run");
  std::istringstream lines(read_file(path, kMaxInspected));
  Inspection found;
  bool torn = false;
  for (std::string line; std::getline(lines, line);) {
    torn = lines.eof();
    if (!torn) found.add(line);
  }
  if (torn) found.damaged.emplace_back("the last line was cut off: the program ended while it was written");
  std::string summary = concat(folder, ": ", found.lines, " lines of the journal");
  if (found.end.is_null())
    summary += concat("; the run was not ended by the program",
                      found.step.empty() ? "" : ", the last step that began: " + found.step);
  summary += "\n";
  if (can_go_on(folder, found.end))
    summary += concat("go on with it: stonestack run --resume ", folder, "\n");
  for (const std::string& line : found.damaged) summary += line + "\n";
  RunInspection result;
  result.whole = found.damaged.empty() && !found.end.is_null();
  result.text = found.text + summary;
  result.json = nlohmann::ordered_json{{"schema", "stonestack.inspect/1"},
                                       {"lines", found.lines},
                                       {"damaged", found.damaged},
                                       {"last_step", found.step},
                                       {"stack", names_of(found.last.at("stack"))},
                                       {"loose", names_of(found.last.at("loose"))},
                                       {"outcomes", found.outcomes},
                                       {"end", found.end},
                                       {"resumable", can_go_on(folder, found.end)}}
                    .dump(2) +
                "\n";
  return result;
}

}  // namespace stonestack::stacking
