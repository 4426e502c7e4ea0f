#include <algorithm>
#include <cmath>

#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/picture.hpp"
#include "stonestack/report/plan_preview.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr double kSamplePeriod = 0.008;  // s: the control period of a CB3
constexpr double kPlotPeriod = 0.02;     // s
constexpr double kUnit = 1e-3;           // by which a quaternion's norm may be off

const char* kind_text(PlanStep::Kind kind) {
  switch (kind) {
    case PlanStep::Kind::kOpen:
      return "open";
    case PlanStep::Kind::kTransit:
      return "transit";
    case PlanStep::Kind::kApproach:
      return "approach";
    case PlanStep::Kind::kGrasp:
      return "grasp";
    case PlanStep::Kind::kLift:
      return "lift";
    case PlanStep::Kind::kDescent:
      return "descent";
    case PlanStep::Kind::kRelease:
      return "release";
    case PlanStep::Kind::kRetreat:
      return "retreat";
  }
  return "unknown";
}

json step_json(const PlanStep& step) {
  json points = json::array();
  const auto& t = step.trajectory;
  for (std::size_t i = 0; i < t.time.size(); ++i)
    points.push_back({{"t", t.time[i]},
                      {"q", std::vector<double>(t.q[i].begin(), t.q[i].end())},
                      {"qd", std::vector<double>(t.qd[i].begin(), t.qd[i].end())}});
  return {{"kind", kind_text(step.kind)}, {"name", step.name},           {"opening", step.opening},
          {"spacing", step.spacing},      {"threshold", step.threshold}, {"trajectory", points}};
}

/// With so many digits that accelerations can be computed from differences.
std::string csv_number(double value) {
  return format(",%.12g", value);
}

/// `path`: of the file that holds it.
NamedPose read_placement(const json& entry, const std::string& path) {
  const auto& t = entry.at("T_W_O");
  const auto number = [&](const char* key) { return t.at(key).get<double>(); };
  const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
  if (!(std::abs(q.norm() - 1.0) < kUnit))
    throw FileError(path, concat("a target's quaternion has the norm ", q.norm(), ", not 1"),
                    "make it with `stonestack search --json`");
  return {entry.at("stone").get<std::string>(), make_pose({number("x"), number("y"), number("z")}, q)};
}

std::vector<PlanMoment> moments_of(const ScenePlan& planned) {
  return preview(planned.scene, planned.task, planned.plan, kPlotPeriod);
}

}  // namespace

std::vector<NamedPose> read_search_targets(const std::string& path) {
  try {
    const auto found = json::parse(read_file(path, std::size_t{1} << 24));
    std::vector<NamedPose> targets{read_placement(found.at("placements").at(0), path)};
    if (found.contains("alternatives"))
      for (const auto& entry : found.at("alternatives")) targets.push_back(read_placement(entry, path));
    return targets;
  } catch (const json::exception& problem) {
    throw FileError(path, concat("holds no placement: ", problem.what()),
                    "make it with `stonestack search --json`");
  }
}

std::string plan_json(const ScenePlan& planned) {
  json steps = json::array();
  for (const auto& step : planned.plan.steps) steps.push_back(step_json(step));
  return document({{"schema", "stonestack.plan/1"},
                   {"stone", planned.task.stone->name},
                   {"T_W_O", pose_json(planned.task.T_W_O_place)},
                   {"steps", steps},
                   {"T_O_T", pose_json(planned.plan.T_O_T)},
                   {"seconds", planned.plan.seconds}},
                  1);
}

std::string plan_table(const ScenePlan& planned) {
  const auto& p_W = planned.task.T_W_O_place.translation();
  std::string text =
      format("%s to %.3f, %.3f, %.3f\n", planned.task.stone->name.c_str(), p_W.x(), p_W.y(), p_W.z());
  for (const auto& step : planned.plan.steps)
    text +=
        format("%-10s %6.2f s  %s\n", kind_text(step.kind), step.trajectory.duration(), step.name.c_str());
  return text + format("%.1f s of motion\n", planned.plan.seconds);
}

std::string plan_csv(const ScenePlan& planned) {
  std::string text = "step,kind,t,q0,q1,q2,q3,q4,q5,qd0,qd1,qd2,qd3,qd4,qd5\n";
  for (std::size_t s = 0; s < planned.plan.steps.size(); ++s) {
    const PlanStep& step = planned.plan.steps[s];
    if (step.trajectory.time.empty()) continue;
    const double duration = step.trajectory.duration();
    const auto samples = static_cast<long>(std::ceil(duration / kSamplePeriod));
    for (long i = 0; i <= samples; ++i) {
      const double t = std::min(duration, static_cast<double>(i) * kSamplePeriod);
      const JointState state = sample(step.trajectory, t);
      text += concat(s, ',', kind_text(step.kind)) + csv_number(t);
      for (const double q : state.q) text += csv_number(q);
      for (const double qd : state.qd) text += csv_number(qd);
      text += '\n';
    }
  }
  return text;
}

void plot_plan(const std::string& path, const ScenePlan& planned) {
  write_file(path, plan_plot(planned.plan, moments_of(planned)));
}

void draw_plan(const std::string& folder, const ScenePlan& planned, int width) {
  View view;
  view.p_W_eye = {2.1, -1.5, 1.1};
  view.p_W_target = {0.45, 0.05, 0.35};
  view.width = width;
  view.height = 3 * width / 4;
  const auto keys = key_moments(moments_of(planned));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    throw_if_interrupted();
    const char* name = i == 0 ? "start" : kind_text(planned.plan.steps[keys[i].step].kind);
    write_png(concat(folder, '/', i < 10 ? "0" : "", i, '_', name, ".png"),
              draw(drawn_moment(planned.scene, planned.task, planned.plan, keys[i]), view));
  }
}

}  // namespace stonestack::report
