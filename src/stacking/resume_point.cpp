#include "stacking/resume_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "geometry/pose_json.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;

constexpr const char* kResumeSchema = "stonestack.resume/1";
constexpr std::size_t kMaxResume = std::size_t{1} << 28;
constexpr double kJointDigits = 1e7;  // a rad and a rad/s
/// Names of PlanStep::Kind, in its order.
constexpr std::array<std::string_view, 8> kStepKinds{"open", "transit", "approach", "grasp",
                                                     "lift", "descent", "release",  "retreat"};

json joints_json(const std::vector<Joints>& path) {
  json list = json::array();
  for (const Joints& q : path)
    for (const double value : q) list.push_back(std::round(kJointDigits * value) / kJointDigits);
  return list;
}

std::vector<Joints> joints_of(const json& list) {
  std::vector<Joints> path(list.size() / 6);
  for (std::size_t k = 0; k < path.size(); ++k)
    for (std::size_t i = 0; i < 6; ++i)
      path[k][static_cast<Eigen::Index>(i)] = list.at(6 * k + i).get<double>();
  return path;
}

json step_json(const PlanStep& step) {
  return {{"kind", kStepKinds[static_cast<std::size_t>(step.kind)]},
          {"name", step.name},
          {"time", step.trajectory.time},
          {"q", joints_json(step.trajectory.q)},
          {"qd", joints_json(step.trajectory.qd)},
          {"opening", step.opening},
          {"spacing", step.spacing},
          {"finger_speed", step.finger_speed},
          {"force", step.force},
          {"threshold", step.threshold}};
}

PlanStep step_of(const json& j) {
  PlanStep step;
  const auto kind = std::find(kStepKinds.begin(), kStepKinds.end(), j.at("kind").get<std::string>());
  require(kind != kStepKinds.end(), "no step is of kind ", j.at("kind"));
  step.kind = static_cast<PlanStep::Kind>(kind - kStepKinds.begin());
  step.name = j.at("name").get<std::string>();
  step.trajectory = {j.at("time").get<std::vector<double>>(), joints_of(j.at("q")), joints_of(j.at("qd"))};
  if (!step.trajectory.q.empty()) {
    const std::string fault = malformed(step.trajectory);
    require(fault.empty(), "step ", step.name, ": ", fault);
  }
  step.opening = j.at("opening").get<double>();
  step.spacing = j.at("spacing").get<double>();
  step.finger_speed = j.at("finger_speed").get<double>();
  step.force = j.at("force").get<double>();
  step.threshold = j.at("threshold").get<double>();
  return step;
}

json seconds_json(const StageSeconds& s) {
  return {{"detection", s.detection},
          {"search", s.search},
          {"planning", s.planning},
          {"motion", s.motion},
          {"beside_motion", s.beside_motion}};
}

StageSeconds seconds_of(const json& j) {
  const auto number = [&](const char* name) { return j.at(name).get<double>(); };
  return {number("detection"), number("search"), number("planning"), number("motion"),
          number("beside_motion")};
}

ResumePoint point_of(const json& j, const Catalogue& catalogue) {
  require(j.at("schema").get<std::string>() == kResumeSchema, "its schema is not ", kResumeSchema);
  ResumePoint point;
  point.seconds = seconds_of(j.at("seconds"));
  point.lines = j.at("journal").get<long>();
  for (const json& line : j.at("learned"))
    point.learned.emplace_back(line.at("kind").get<std::string>(), line.at("data").dump());
  if (j.contains("state")) point.state = state_of(j.at("state"), catalogue);
  if (!j.contains("motion")) return point;
  require(point.state && point.state->memory.attempt, "it has a motion without what it is for");
  point.motion.emplace();
  for (const json& step : j.at("motion")) point.motion->steps.push_back(step_of(step));
  point.motion->T_O_T = point.state->memory.attempt->T_O_T;
  return point;
}

}  // namespace

ResumePoint read_resume_point(const std::string& folder, const Catalogue& catalogue) {
  const std::string path = folder + kResumeFile;
  std::string problem;
  try {
    return point_of(json::parse(read_file(path, kMaxResume)), catalogue);
  } catch (const json::exception& wrong) {
    problem = wrong.what();
  } catch (const InvalidArgument& wrong) {
    problem = wrong.what();
  }
  throw FileError(path, "is not what a run wrote that can go on: " + problem,
                  "start a new run; see with `stonestack inspect` what this one has done");
}

void complete_journal(Journal& journal, const ResumePoint& point) {
  const long written = std::max(0L, journal.lines() - point.lines);
  for (auto k = static_cast<std::size_t>(written); k < point.learned.size(); ++k)
    journal.record(point.learned[k].first, point.learned[k].second);
}

void ResumeWriter::write(const json& content) const {
  if (folder_.empty()) return;
  json all{{"schema", kResumeSchema},
           {"journal", journal_ == nullptr ? 0 : journal_->lines()},
           {"learned", json::array()},
           {"seconds", seconds_json(seconds_)}};
  all.update(content);
  write_file(folder_ + kResumeFile, all.dump() + "\n");
}

void ResumeWriter::begin() const {
  write(json::object());
}

void ResumeWriter::observed(const WorldEstimate& world, const RunMemory& memory,
                            const std::vector<Event>& learned) const {
  if (folder_.empty()) return;
  json lines = json::array();
  for (const Event& event : learned)
    if (const auto [kind, data] = to_record(event, *models_.catalogue); !kind.empty())
      lines.push_back({{"kind", kind}, {"data", json::parse(data)}});
  write({{"learned", lines}, {"state", state_json(world, memory, models_, options_)}});
}

void ResumeWriter::acting(const WorldEstimate& world, const RunMemory& memory, const MotionPlan& plan) const {
  if (folder_.empty()) return;
  json content{{"state", state_json(world, memory, models_, options_)}};
  if (!plan.pick_and_place.steps.empty()) {
    json steps = json::array();
    for (const PlanStep& step : plan.pick_and_place.steps) steps.push_back(step_json(step));
    content["motion"] = steps;
  }
  write(content);
}

}  // namespace stonestack::stacking
